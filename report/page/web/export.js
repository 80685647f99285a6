// SPDX-License-Identifier: Apache-2.0
// Three buttons below a chart: the drawing as SVG or PNG, its rows as CSV. Colours of the page are variables, which a
// file does not have: they are replaced by what they are.
'use strict';

const grtx_export = (() => {
  const kScale = 2; // pixels of a PNG per pixel of the page

  const save = (name, href) => {
    const link = document.createElement('a');
    link.download = name;
    link.href = href;
    link.click();
  };

  /// The drawing as the text of a file of its own.
  const svg_of = (figure) => {
    const drawn = figure.querySelector('.drawing svg'),
      copy = drawn.cloneNode(true),
      style = getComputedStyle(document.documentElement);
    const plain = (text) => text.replace(/var\((--[\w-]+)(?:,\s*(var\([^)]*\)|[^)]*))?\)/g, (whole, name, otherwise) => {
      const value = style.getPropertyValue(name).trim();
      return plain(value || otherwise || 'black');
    });
    for (const element of [copy, ...copy.querySelectorAll('*')]) {
      for (const { name, value } of [...element.attributes]) if (value.includes('var(')) element.setAttribute(name, plain(value));
    }
    const box = drawn.getBoundingClientRect();
    copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
    copy.setAttribute('width', box.width);
    copy.setAttribute('height', box.height);
    copy.style.background = plain('var(--card)');
    return { text: new XMLSerializer().serializeToString(copy), width: box.width, height: box.height };
  };
  const data_uri = (type, text) => `data:${type};charset=utf-8,${encodeURIComponent(text)}`;

  const png_of = async (figure) => {
    const { text, width, height } = svg_of(figure),
      picture = new Image();
    picture.src = data_uri('image/svg+xml', text);
    await picture.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [width * kScale, height * kScale];
    canvas.getContext('2d').drawImage(picture, 0, 0, canvas.width, canvas.height);
    return canvas.toDataURL('image/png');
  };

  /// Titles of fields, as the chart's axes have them.
  const titles_of = (part, found = {}) => {
    if (part !== null && typeof part === 'object') {
      if (typeof part.field === 'string' && typeof part.title === 'string' && !(part.field in found)) found[part.field] = part.title;
      for (const [name, inner] of Object.entries(part)) if (name !== 'data') titles_of(inner, found);
    }
    return found;
  };
  /// Rows of the chart, a column for each field; what only draws them (tips t0, t1, sizes) is none of its data.
  const csv_of = (spec) => {
    const drawing = /^(t\d+|rank|size|words|order|place|shown)$/,
      titles = titles_of(spec),
      rows = spec.data.values,
      names = [...new Set(rows.flatMap((row) => Object.keys(row)))].filter((name) => !drawing.test(name));
    const cell = (value) => {
      const text = value === undefined || value === null ? '' : String(value);
      return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    };
    return [names.map((name) => titles[name] || name), ...rows.map((row) => names.map((name) => row[name]))].map((line) => line.map(cell).join(',')).join('\n') + '\n';
  };

  return (figure, spec) => {
    let place = figure.querySelector('.export');
    if (place === null) {
      place = document.createElement('p');
      place.className = 'export';
      figure.append(place);
    }
    const button = (name, act) => {
      const made = document.createElement('button');
      made.type = 'button';
      made.textContent = name;
      made.title = `This chart as ${name}`;
      made.addEventListener('click', act);
      return made;
    };
    place.replaceChildren(
      button('SVG', () => save(`${figure.id}.svg`, data_uri('image/svg+xml', svg_of(figure).text))),
      button('PNG', async () => save(`${figure.id}.png`, await png_of(figure))),
      button('CSV', () => save(`${figure.id}.csv`, data_uri('text/csv', csv_of(spec)))),
    );
  };
})();
