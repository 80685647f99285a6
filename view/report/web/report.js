// SPDX-License-Identifier: Apache-2.0
// Draws the page's charts and links those of a sweep: a box drawn in one chooses points in all, and in the table.
'use strict';

(() => {
  const font = getComputedStyle(document.body).fontFamily;
  const ink = 'var(--ink)', muted = 'var(--muted)', line = 'var(--line)';
  const text = { labelFont: font, titleFont: font, titleFontSize: 12, titleFontWeight: 500 };
  const config = (width) => ({
    background: null,
    font,
    view: { stroke: line },
    axis: { ...text, labelFontSize: width < 600 ? 11 : 12, labelColor: muted, titleColor: ink, gridColor: line, domainColor: line, tickColor: line, labelLimit: width < 600 ? 165 : 320 },
    legend: {
      ...text, labelFontSize: 12, labelColor: ink, titleColor: ink, symbolType: 'circle', symbolStrokeWidth: 0, labelLimit: 130,
      columns: Math.max(2, Math.floor(width / 150)),
    },
    text: { color: ink },
  });

  const kBarPixels = 20;  // as in charts.cpp

  // Charts that were drawn, by the id of their figure.
  const views = new Map();

  // Names and values in a tooltip come from foreign files: they are text, whatever they are called. (The library's own
  // tooltip shows a field with the name "image" as the picture at that address.)
  const tooltip_html = (fields, to_html) => {
    const rows = Object.entries(fields).filter(([, value]) => value !== undefined && value !== '');
    return `<table>${rows.map(([name, value]) => `<tr><td class="key">${to_html(name)}</td><td class="value">${to_html(value)}</td></tr>`).join('')}</table>`;
  };

  const draw = async (figure) => {
    const place = figure.querySelector('.drawing');
    const spec = JSON.parse(figure.querySelector('.spec').textContent);
    spec.$schema = 'https://vega.github.io/schema/vega-lite/v6.json';  // names the language; nothing is loaded
    const result = await vegaEmbed(place, spec, {
      mode: 'vega-lite', renderer: 'svg', actions: false, config: config(place.clientWidth),
      tooltip: { theme: 'custom', formatTooltip: tooltip_html },
    });
    views.set(figure.id, { figure, spec, view: result.view });
  };

  // The view of a scene that a group shows.
  const shown_view = (group) => {
    const select = document.querySelector(`.controls[data-group="${group}"] .view`);
    return select ? Number(select.value) : 0;
  };

  // Charts of a group share one set of chosen points (null: all), chosen by a box in one of them, its holder.
  const choose = (group, ids, holder) => {
    const shown_now = shown_view(group);
    for (const { figure, spec, view } of views.values()) {
      if (figure.dataset.group !== group) continue;
      if (figure.dataset.role === 'bars') {
        const drawn = spec.data.values.filter((bar) => bar.view === shown_now && (ids === null ? bar.front : ids.includes(bar.id)));
        if (ids !== null && drawn.length === 0) continue;  // an empty box leaves the bars: without any they have no axis
        view.height(kBarPixels * Math.max(1, new Set(drawn.map((bar) => bar.id)).size));
      } else if (figure !== holder) {
        view.signal('brush_x', [0, 0]).signal('brush_y', [0, 0]);  // its own box goes
      }
      view.signal('shown', shown_now).signal('picked', ids).runAsync();
    }
    const table = document.getElementById(group + '_points');
    if (!table) return;
    let shown = 0, all = 0;
    for (const row of table.tBodies[0].rows) {
      const in_view = Number(row.dataset.view) === shown_now;
      row.hidden = !in_view || (ids !== null && !ids.includes(Number(row.dataset.id)));
      all += in_view ? 1 : 0;
      shown += row.hidden ? 0 : 1;
    }
    const status = document.querySelector(`.controls[data-group="${group}"] .chosen`);
    if (status) status.textContent = ids === null ? `${all} points` : `${shown} of ${all} points chosen`;
  };

  // Time over time, with the widest interval that two estimates leave. over: "design:NAME", of the same keys, or
  // "point:NUMBER", of which the keys differ; then design and machine are the same.
  const speedups = (group, over) => {
    const rows = [...document.getElementById(group + '_points').tBodies[0].rows];
    const [kind, wanted] = [over.slice(0, over.indexOf(':')), over.slice(over.indexOf(':') + 1)];
    const place = (row) => row.dataset.view + (kind === 'design' ? ' ' + row.dataset.keys : '');
    const others = new Map(rows.filter((row) => (kind === 'design' ? row.dataset.design : row.dataset.machine) === wanted)
      .map((row) => [place(row), row]));
    const times = (ratio) => `${ratio.toFixed(2)}×`;
    for (const row of rows) {
      const cell = row.querySelector('.speedup'), other = others.get(place(row));
      const alike = other && (kind === 'design' || (other.dataset.design === row.dataset.design && other.dataset.base === row.dataset.base));
      const ratio = alike ? Number(other.dataset.time) / Number(row.dataset.time) : NaN;
      cell.textContent = Number.isFinite(ratio) ? times(ratio) : '';
      if (!Number.isFinite(ratio) || other === row || !row.dataset.low || !other.dataset.low) continue;
      const interval = document.createElement('span');
      interval.className = 'interval';
      interval.textContent = ` (${times(other.dataset.low / row.dataset.high)} to ${times(other.dataset.high / row.dataset.low)})`;
      cell.append(interval);
    }
  };

  const link = (group) => {
    const charts = [...views.values()].filter(({ figure }) => figure.dataset.group === group && figure.dataset.role === 'pareto');
    let holder = null;
    for (const { figure, spec, view } of charts) {
      // A listener runs inside the chart's own update: the choice waits for the next frame, and only the last is made.
      let waiting = 0;
      view.addSignalListener('brush', (name, box) => {
        cancelAnimationFrame(waiting);
        waiting = requestAnimationFrame(() => {
          if (!box || !box.time || !box.cost) {
            if (holder !== figure) return;  // another chart's box took this one's place
            holder = null;
            choose(group, null, null);
            return;
          }
          holder = figure;
          const [left, right] = [Math.min(...box.time), Math.max(...box.time)];
          const [low, high] = [Math.min(...box.cost), Math.max(...box.cost)];
          const inside = (p) => p.view === shown_view(group) && p.time >= left && p.time <= right && p.cost >= low && p.cost <= high;
          choose(group, spec.data.values.filter(inside).map((p) => p.id), figure);
        });
      });
    }
    const controls = document.querySelector(`.controls[data-group="${group}"]`);
    if (!controls) return;
    controls.hidden = false;
    controls.querySelector('.colour').addEventListener('change', (event) => {
      for (const { view } of charts) view.signal('colour_by', event.target.value).runAsync();
    });
    const rest = () => {
      holder = null;
      choose(group, null, null);
    };
    const view_choice = controls.querySelector('.view');
    if (view_choice) view_choice.addEventListener('change', rest);
    controls.querySelector('.reference').addEventListener('change', (event) => speedups(group, event.target.value));
    controls.querySelector('.all').addEventListener('click', rest);
    choose(group, null, null);
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
      button.textContent = title.textContent;
      title.replaceChildren(button);
      button.addEventListener('click', () => {
        const down = title.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
        titles.forEach((other) => other.removeAttribute('aria-sort'));
        title.setAttribute('aria-sort', down === 1 ? 'ascending' : 'descending');
        const body = table.tBodies[0];
        const compare = (a, b) => {
          if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1;  // empty cells last
          if (typeof a === typeof b) return down * (a < b ? -1 : a > b ? 1 : 0);
          return typeof a === 'number' ? -1 : 1;
        };
        body.append(...[...body.rows].sort((a, b) => compare(key(a, column), key(b, column))));
      });
    });
  };

  const begin = async () => {
    document.querySelectorAll('section.sweep table').forEach(sortable);
    if (typeof vegaEmbed === 'function') {
      await Promise.all([...document.querySelectorAll('figure.chart')].map(draw));
      new Set([...document.querySelectorAll('.controls')].map((c) => c.dataset.group)).forEach(link);
    }
    document.documentElement.dataset.ready = 'yes';  // for tests and screenshots
  };
  // Tables that are closed on the screen are printed too.
  let opened = [];
  window.addEventListener('beforeprint', () => {
    opened = [...document.querySelectorAll('details:not([open])')].filter((d) => d.dataset.print !== 'no');
    opened.forEach((d) => { d.open = true; });
  });
  window.addEventListener('afterprint', () => opened.forEach((d) => { d.open = false; }));
  begin();
})();
