// SPDX-License-Identifier: Apache-2.0
// Draws the page's charts, and makes the tables of a sweep sortable.
'use strict';

(() => {
  const font = getComputedStyle(document.body).fontFamily;
  const ink = 'var(--ink)',
    muted = 'var(--muted)',
    line = 'var(--line)';
  const text = { labelFont: font, titleFont: font, titleFontSize: 12, titleFontWeight: 500 };
  const config = (width) => ({
    background: null,
    font,
    view: { stroke: line },
    axis: {
      ...text,
      labelFontSize: width < 600 ? 11 : 12,
      labelColor: muted,
      titleColor: ink,
      gridColor: line,
      domainColor: line,
      tickColor: line,
      labelLimit: Math.min(320, width / 2),
      labelOverlap: true,
      labelSeparation: 8,
    },
    axisYDiscrete: { labelOverlap: false }, // a bar without a name says nothing
    axisX: { tickCount: Math.max(3, Math.floor(width / 110)) },
    legend: {
      ...text,
      labelFontSize: 12,
      labelColor: ink,
      titleColor: ink,
      symbolType: 'circle',
      symbolStrokeWidth: 0,
      symbolOpacity: 1,
      labelLimit: width - 60,
      columns: Math.max(2, Math.floor(width / 150)),
      ...(width < 400 ? { layout: { bottom: { anchor: 'end' } } } : {}), // below the axis's labels, too
    },
    text: { color: ink },
  });

  // Names and values in a tooltip come from foreign files: they are text, whatever they are called. (The library's own
  // tooltip shows a field with the name "image" as the picture at that address.)
  const tooltip_html = (fields, to_html) => {
    const rows = Object.entries(fields).filter(([, value]) => value !== undefined && value !== '');
    const cells = ([name, value]) => `<tr><td class="key">${to_html(name)}</td><td class="value">${to_html(value)}</td></tr>`;
    return `<table>${rows.map(cells).join('')}</table>`;
  };

  const embed = (place, spec) => {
    spec.$schema = 'https://vega.github.io/schema/vega-lite/v6.json'; // names the language; nothing is loaded
    return vegaEmbed(place, spec, {
      mode: 'vega-lite',
      renderer: 'svg',
      actions: false,
      config: config(place.clientWidth),
      tooltip: { theme: 'custom', formatTooltip: tooltip_html },
    });
  };
  const draw = async (figure) => {
    const spec = JSON.parse(figure.querySelector('.spec').textContent);
    await embed(figure.querySelector('.drawing'), spec);
    grtx_export(figure, spec);
  };

  // A click on a column's title sorts by it.
  const sortable = (table) => {
    const titles = [...table.tHead.rows[0].cells];
    const key = (row, column) => {
      const words = row.cells[column].textContent.trim();
      const value = Number(words.replace(/[,#×%]/g, ''));
      return words === '' ? null : Number.isNaN(value) ? words : value;
    };
    titles.forEach((title, column) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.append(...title.childNodes);
      title.append(button);
      button.addEventListener('click', () => {
        const down = title.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
        titles.forEach((other) => other.removeAttribute('aria-sort'));
        title.setAttribute('aria-sort', down === 1 ? 'ascending' : 'descending');
        const body = table.tBodies[0];
        const compare = (a, b) => {
          if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1; // empty cells last
          if (typeof a === typeof b) return down * (a < b ? -1 : a > b ? 1 : 0);
          return typeof a === 'number' ? -1 : 1;
        };
        body.append(...[...body.rows].sort((a, b) => compare(key(a, column), key(b, column))));
      });
    });
  };

  /** On a phone each row of a table becomes a block with a line for each cell, which names its column (report.css). */
  const stackable = (table) => {
    const names = [...table.tHead.rows[0].cells].map((cell) => cell.textContent);
    if (names.length < 4 || table.rows.length > 42) return;
    table.classList.add('stacks');
    for (const row of table.tBodies[0].rows)
      [...row.cells].slice(1).forEach((cell, i) => {
        cell.dataset.what = names[i + 1];
      });
  };

  /** A figure stays on the line of its unit, and an option of a command is not broken behind its dashes. */
  const keep_whole = (box) => {
    const whole = /(--[a-z-]+(?: \d+)?|\d[\d.,]* (?:%|dB|mm²|[mµnp]?[sJ]|[kMG]?B|[kMG]?rays\/s)(?!\p{L}))/u;
    const walker = document.createTreeWalker(box, NodeFilter.SHOW_TEXT),
      texts = [];
    while (walker.nextNode()) texts.push(walker.currentNode);
    for (const text of texts) {
      const parts = text.textContent.split(whole);
      if (parts.length < 2) continue;
      const spans = parts.map((part, i) => (i % 2 === 0 ? part : Object.assign(document.createElement('span'), { className: 'whole', textContent: part })));
      text.replaceWith(...spans);
    }
  };

  const begin = async () => {
    document.querySelectorAll('main p, .speeds td').forEach(keep_whole);
    document.querySelectorAll('.scroll table').forEach(stackable);
    document.querySelectorAll('section.sweep table').forEach(sortable);
    if (typeof vegaEmbed === 'function') {
      await Promise.all([...document.querySelectorAll('figure.chart')].map(draw));
      if (typeof grtx_explore === 'function') await grtx_explore(embed, stackable);
    }
    document.documentElement.dataset.ready = 'yes'; // for tests and screenshots
  };
  // Tables that are closed on the screen are printed too.
  let opened = [];
  window.addEventListener('beforeprint', () => {
    opened = [...document.querySelectorAll('details:not([open])')].filter((d) => d.dataset.print !== 'no');
    opened.forEach((d) => {
      d.open = true;
    });
  });
  window.addEventListener('afterprint', () =>
    opened.forEach((d) => {
      d.open = false;
    }),
  );
  begin();
})();
