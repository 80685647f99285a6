// SPDX-License-Identifier: Apache-2.0
// The explorer of points: filters, any value over any other, parallel coordinates, a line for each value of a key,
// effects of keys, and the parts of chosen points. Data, from sweep_section.cpp and search_section.cpp:
// {subject, views: [title], designs: [name], fields: [title], metrics: [{title, unit, more}], stalls, energy: [part],
//  points: [{id, label, name, view, keys, machine, base, design, fields: [value], metrics: [number], ...}]}
'use strict';

const grtx_explore = (() => {
  const kMostBars = 24,
    kMostRows = 200,
    kMostChips = 12;

  /// A title that may go on in the next line behind a dot or an underscore.
  const breakable = (title) => title.split(/(?<=[._])(?=\p{L})/u).flatMap((part, i) => (i === 0 ? [part] : [document.createElement('wbr'), part]));
  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name in made) made[name] = value;
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  };
  const choice = (name, label, options, chosen) => {
    const select = element('select', { className: name, 'aria-label': label });
    for (const [value, text] of options) select.append(element('option', { value, textContent: text, selected: value === chosen }));
    return element('label', {}, `${label} `, select);
  };
  const { shown, scale_of, by_size } = grtx_explore_charts;

  class Explorer {
    constructor(box, embed, stackable) {
      this.stackable = stackable;
      this.box = box;
      this.embed = embed;
      this.id = box.dataset.group;
      this.data = JSON.parse(box.querySelector('.points').textContent);
      this.points = this.data.points;
      this.table = document.getElementById(box.dataset.table);
      this.excluded = new Map(); // field -> values that are not shown
      this.drawn = new Map(); // figure -> what embed() returned
      this.runs = new Map(); // figure -> number of its last drawing
      this.view = 0;
      this.chosen = null; // ids; null: all
      this.cursor = null;
      this.find_fields();
      this.find_metrics();
      this.build();
    }

    // What there is to choose from.

    find_fields() {
      this.fields = this.data.fields
        .map((title, at) => {
          const values = [];
          for (const p of this.points) if (p.fields[at] !== null && !values.includes(p.fields[at])) values.push(p.fields[at]);
          const numeric = values.every((v) => typeof v === 'number');
          return { title, at, values: numeric ? values.sort(by_size) : values, numeric };
        })
        .filter((field) => field.values.length > 1);
      this.keys = this.fields.filter((field) => !['design', 'machine', 'stage'].includes(field.title));
      const design = this.fields.find((field) => field.title === 'design' || field.title === 'stage');
      this.colour_field = design || this.fields[0] || null;
    }

    find_metrics() {
      const usable = (at) => this.points.some((p) => Number.isFinite(p.metrics[at]) && p.metrics[at] !== null);
      this.metrics = this.data.metrics.map((metric, at) => ({ ...metric, at })).filter((metric) => usable(metric.at));
      if (this.data.designs.length === 0) return;
      this.speedup = { title: 'speed-up', unit: '×', more: true, at: this.data.metrics.length };
      this.over(this.first_reference());
      if (this.points.some((p) => Number.isFinite(p.metrics[this.speedup.at]))) this.metrics.push(this.speedup);
    }

    first_reference() {
      const { designs } = this.data;
      if (designs.length === 1 && this.machines().length > 1) return `machine:${this.machines()[0]}`;
      if (designs.length > 1) return `design:${designs.includes('baseline') ? 'baseline' : designs[0]}`;
      return this.points.length > 0 ? `point:${this.points[0].machine}` : '';
    }

    machines() {
      return [...new Set(this.points.map((p) => p.base))];
    }
    /// Design and varied keys of a point: the same on all machines.
    but_for_machine(p) {
      return JSON.stringify([p.design, ...p.fields.map((value, at) => (this.data.fields[at] === 'machine' ? null : value))]);
    }

    /// Speed-ups over "design:NAME", of the same keys on the same machine, "machine:NAME", of the same design and keys,
    /// or "point:NUMBER", of the same design and machine.
    over(reference) {
      this.reference = reference;
      const [kind, wanted] = [reference.slice(0, reference.indexOf(':')), reference.slice(reference.indexOf(':') + 1)];
      const own = { design: (p) => p.design, machine: (p) => p.base, point: (p) => String(p.machine) }[kind];
      const place = (p) => `${p.view} ${kind === 'design' ? p.keys : kind === 'machine' ? this.but_for_machine(p) : ''}`;
      const others = new Map(this.points.filter((p) => own(p) === wanted).map((p) => [place(p), p]));
      for (const p of this.points) {
        const other = others.get(place(p));
        const alike = other && (kind !== 'point' || (other.design === p.design && other.base === p.base));
        p.reference = alike ? other : null;
        p.metrics[this.speedup.at] = alike ? other.metrics[0] / p.metrics[0] : NaN;
      }
    }

    speedup_text(p) {
      const ratio = this.speedup ? p.metrics[this.speedup.at] : NaN;
      if (!Number.isFinite(ratio)) return ['', ''];
      const both = p.reference !== p && p.interval && p.reference.interval;
      const ends = both ? [p.reference.interval[0] / p.interval[1], p.reference.interval[1] / p.interval[0]] : null;
      return [`${ratio.toFixed(2)}×`, ends ? ` (${ends[0].toFixed(2)}× to ${ends[1].toFixed(2)}×)` : ''];
    }

    kept() {
      return this.points.filter((p) => p.view === this.view && [...this.excluded].every(([at, values]) => !values.has(p.fields[at])));
    }

    // A value to draw: "m0" is a metric, "f2" a field.

    axis_choices() {
      return [...this.metrics.map((m) => [`m${m.at}`, m.title]), ...this.fields.filter((f) => f.numeric).map((f) => [`f${f.at}`, f.title])];
    }
    quantity(name) {
      const at = Number(name.slice(1));
      if (name[0] === 'f') return { title: this.data.fields[at], unit: '', field: true, of: (p) => p.fields[at] };
      const metric = this.metrics.find((m) => m.at === at);
      return { ...metric, of: (p) => p.metrics[at] };
    }

    // The page's parts.

    build() {
      const title = (p) => `${p.label} ${p.name}`.trim();
      const references = this.data.designs.length > 1 ? this.data.designs.map((d) => [`design:${d}`, `${d} with the same keys`]) : [];
      if (this.machines().length > 1)
        references.push(...this.machines().map((m) => [`machine:${m}`, `machine ${m}, the same design and keys`]));
      const known = new Set();
      for (const p of this.points) {
        if (this.speedup && !known.has(p.machine)) references.push([`point:${p.machine}`, title(p)]);
        known.add(p.machine);
      }
      const colours = [...this.fields.map((f) => [String(f.at), f.title]), ['none', 'nothing']];
      const controls = element('p', { className: 'controls' });
      controls.dataset.group = this.id;
      if (this.data.views.length > 1)
        controls.append(
          choice(
            'view',
            'View',
            this.data.views.map((v, i) => [String(i), v]),
            '0',
          ),
        );
      if (this.speedup) controls.append(choice('reference', 'Speed-up over', references, this.reference));
      controls.append(choice('colour', 'Colour by', colours, this.colour_field ? String(this.colour_field.at) : 'none'));
      this.status = element('span', { className: 'chosen', role: 'status' });
      controls.append(element('button', { type: 'button', className: 'all', textContent: 'Show all points' }), this.status);
      this.box.append(controls, this.filters());
      const on = (name, act) => {
        const select = controls.querySelector(`.${name}`);
        if (select) select.addEventListener('change', () => act(select.value));
      };
      on('view', (value) => {
        this.view = Number(value);
        this.redraw();
      });
      on('colour', (value) => {
        this.colour_field = value === 'none' ? null : this.fields.find((f) => f.at === Number(value));
        this.redraw();
      });
      on('reference', (value) => {
        this.over(value);
        this.redraw();
      });
      controls.querySelector('.all').addEventListener('click', () => this.reset());
      this.build_figures();
    }

    filters() {
      const box = element('details', { className: 'filters', open: innerWidth > 700 }, element('summary', { textContent: 'Filter' }));
      for (const field of this.fields)
        box.append(field.values.length > kMostChips && field.numeric ? this.range(field) : this.chips(field));
      return box;
    }

    exclude(field, values) {
      this.excluded.set(field.at, new Set(values));
      this.redraw();
    }

    chips(field) {
      const group = element('fieldset', {}, element('legend', { textContent: field.title }));
      for (const value of field.values) {
        const box = element('input', { type: 'checkbox', checked: true });
        box.addEventListener('change', () => {
          const off = new Set(this.excluded.get(field.at));
          if (box.checked) off.delete(value);
          else off.add(value);
          this.exclude(field, off);
        });
        const chip = element('label', {}, box, String(value));
        if (field.title === 'design') chip.style.setProperty('--own', this.design_colour(value));
        group.append(chip);
      }
      return group;
    }

    range(field) {
      const options = field.values.map((v, i) => [String(i), String(v)]),
        last = field.values.length - 1;
      const from = choice('from', 'from', options, '0'),
        to = choice('to', 'to', options, String(last));
      const act = () => {
        const [low, high] = [from, to].map((label) => Number(label.querySelector('select').value));
        this.exclude(
          field,
          field.values.filter((v, i) => i < low || i > high),
        );
      };
      for (const label of [from, to]) label.querySelector('select').addEventListener('change', act);
      return element('fieldset', {}, element('legend', { textContent: field.title }), from, to);
    }

    figure(name, controls, caption) {
      const drawing = element('div', { className: 'drawing', role: 'group', tabIndex: 0, 'aria-label': caption });
      const made = element(
        'figure',
        { className: 'chart', id: `${this.id}_${name}` },
        element('div', { className: 'controls' }, ...controls),
        drawing,
        element('figcaption', { textContent: caption }),
      );
      for (const select of made.querySelectorAll('select')) select.addEventListener('change', () => this.draw(name));
      this.box.append(made);
      return made;
    }
    picked(name, select) {
      const found = this.box.querySelector(`#${this.id}_${name} .${select}`);
      return found ? found.value : '';
    }

    build_figures() {
      const axes = this.axis_choices();
      if (axes.length === 0) return;
      this.build_main(axes);
      if (!this.table) {
        this.list = element('div', { className: 'scroll', tabIndex: 0, role: 'region', 'aria-label': 'Chosen points' });
        this.box.append(this.list);
      }
      if (this.keys.length > 0) this.build_key_figures();
      if (!this.data.stalls) return;
      const which = `of the chosen points (until you choose: those on the front), the first ${grtx_explore_charts.kMostBars}`;
      this.figure('stalls_bars', [], `Cycles of the RT units ${which}.`);
      this.figure('energy_bars', [], `Energy by part ${which}.`);
    }

    build_main(axes) {
      const button = (text, label, act) =>
        element('button', { type: 'button', textContent: text, title: label, 'aria-label': label, onclick: act });
      const how = [
        ['fitted', 'fitted'],
        ['zero', 'from 0'],
        ['log', 'logarithmic'],
      ];
      const selects = [
        choice('y', 'Draw', axes, (axes[1] || axes[0])[0]),
        choice('x', 'over', axes, axes[0][0]),
        choice('how', 'axes', how, 'fitted'),
      ];
      const buttons = [
        button('+', 'Zoom in', () => this.zoom(0.5)),
        button('−', 'Zoom out', () => this.zoom(2)),
        button('to chosen', 'Zoom to the chosen points', () => this.zoom_to_chosen()),
        button('whole', 'The whole chart', () => this.zoom(null)),
      ];
      const subject = this.data.subject ? ` Of ${this.data.subject}.` : '';
      const made = this.figure(
        'explore',
        [...selects, ...buttons],
        `A mark is a point; those on the front are large, named, on the dashed line; a ring is a further point in the same place.${this.limits_text()}${subject}` +
          ' Drag a box to choose points; Shift and drag moves, Ctrl and the wheel zooms, a double click ends the box.' +
          ' Keys: arrows go from point to point, Enter chooses, + - 0 zoom, Escape shows all.',
      );
      this.read_out = element('p', { className: 'cursor', role: 'status' });
      made.querySelector('.drawing').after(this.read_out);
      made.querySelector('.drawing').addEventListener('keydown', (event) => this.key(event));
    }

    limits_text() {
      return this.metrics.some((m) => Number.isFinite(m.limit)) ? ' A red line is a limit of the plan.' : '';
    }

    build_key_figures() {
      const metrics = this.metrics.map((m) => [`m${m.at}`, m.title]),
        keys = this.keys.map((f) => [String(f.at), f.title]);
      const series = [...this.fields.map((f) => [String(f.at), f.title]), ['none', 'nothing']];
      const other = this.colour_field !== this.keys[0] ? this.colour_field : this.fields.find((f) => f !== this.keys[0]);
      const selects = [
        choice('metric', 'Draw', metrics, metrics[0][0]),
        choice('key', 'over', keys, keys[0][0]),
        choice('series', 'a line for each', series, other ? String(other.at) : 'none'),
      ];
      this.figure(
        'lines',
        selects,
        'Thin: points that differ in this key alone. Thick: the geometric mean (of shares the arithmetic one) of those thin lines that have all of its values.',
      );
      this.figure(
        'effects',
        [choice('metric', 'What each value does to', metrics, metrics[0][0]), ...this.alike_choice()],
        'Factor against the first value of each key: geometric mean over points that differ in nothing else, of one design and machine.',
      );
      this.figure('parallel', [], 'Parallel coordinates: a line is a point, from key to key and on to what it gives.');
    }

    alike_choice() {
      const alike = [...new Set(this.points.map((p) => this.alike_name(p)))];
      return alike.length > 1
        ? [
            choice(
              'alike',
              'of',
              alike.map((name) => [name, name]),
              alike[alike.length - 1],
            ),
          ]
        : [];
    }
    alike_name(p) {
      return [p.base, p.design].filter((part) => part).join(', ');
    }

    // Drawing.

    async redraw() {
      this.chosen = null;
      this.cursor = null;
      await Promise.all(['explore', 'lines', 'effects', 'parallel'].map((name) => this.draw(name)));
      await this.show_choice();
    }

    async draw(name) {
      const figure = this.box.querySelector(`#${this.id}_${name}`);
      if (!figure) return;
      const run = (this.runs.get(name) || 0) + 1;
      this.runs.set(name, run);
      const spec = this[`${name}_spec`]();
      figure.hidden = spec === null;
      const old = this.drawn.get(name);
      if (old) old.finalize();
      this.drawn.delete(name);
      figure.querySelector('.drawing').replaceChildren();
      if (spec === null) return;
      const result = await this.embed(figure.querySelector('.drawing'), spec);
      grtx_export(figure, spec);
      if (this.runs.get(name) !== run) {
        result.finalize();
        return;
      }
      this.drawn.set(name, result);
      if (name === 'explore') this.listen(result.view);
    }

    // Choosing.

    listen(view) {
      let waiting = 0; // a listener runs inside the chart's own update: the choice waits for the next frame
      view.addSignalListener('brush', (name, box) => {
        cancelAnimationFrame(waiting);
        waiting = requestAnimationFrame(() => {
          if (!box || !box.px || !box.py) {
            this.choose(null);
            return;
          }
          const within = (value, ends) => value >= Math.min(...ends) && value <= Math.max(...ends);
          this.choose(
            this.on_chart.filter((p) => within(this.places[0].of(p), box.px) && within(this.places[1].of(p), box.py)).map((p) => p.id),
          );
        });
      });
    }
    choose(ids) {
      this.chosen = ids;
      return this.show_choice();
    }
    reset() {
      this.excluded.clear();
      for (const box of this.box.querySelectorAll('.filters input')) box.checked = true;
      for (const select of this.box.querySelectorAll('.filters .from')) select.selectedIndex = 0;
      for (const select of this.box.querySelectorAll('.filters .to')) select.selectedIndex = select.options.length - 1;
      return this.redraw();
    }

    async show_choice() {
      for (const name of ['explore', 'parallel']) {
        if (this.drawn.has(name)) this.drawn.get(name).view.signal('picked', this.chosen).runAsync();
      }
      const kept = this.kept(),
        ids = new Set(this.chosen === null ? kept.map((p) => p.id) : this.chosen);
      const all = this.points.filter((p) => p.view === this.view).length,
        some = kept.filter((p) => ids.has(p.id));
      this.status.textContent = some.length === all ? `${all} points` : `${some.length} of ${all} points chosen`;
      if (this.table) this.show_rows(new Set(some.map((p) => p.id)));
      else if (this.list) this.show_list(some);
      this.choices = (this.choices || 0) + 1;
      const choice_now = this.choices;
      await new Promise((resolve) => setTimeout(resolve, 150)); // a box is drawn in many steps: the bars wait for the last
      if (choice_now === this.choices) await Promise.all(['stalls_bars', 'energy_bars'].map((name) => this.draw(name)));
    }
    show_rows(ids) {
      const points = new Map(this.points.map((p) => [p.id, p]));
      for (const row of this.table.tBodies[0].rows) {
        const id = Number(row.dataset.id),
          cell = row.querySelector('.speedup');
        row.hidden = !ids.has(id);
        if (!cell || !points.has(id)) continue;
        const [text, interval] = this.speedup_text(points.get(id));
        cell.textContent = text;
        if (interval) cell.append(element('span', { className: 'interval', textContent: interval }));
      }
    }
    show_list(points) {
      const titles = ['point', ...this.fields.map((f) => f.title), ...this.metrics.map((m) => m.title)];
      const head = element(
        'tr',
        {},
        ...titles.map((t, i) => element('th', { scope: 'col', className: i > this.fields.length ? 'n' : '' }, ...breakable(t))),
      );
      const body = element('tbody');
      for (const p of points.slice(0, kMostRows)) {
        body.append(
          element(
            'tr',
            {},
            element('th', { scope: 'row', textContent: p.label }),
            ...this.fields.map((f) => element('td', { textContent: p.fields[f.at] === null ? '' : String(p.fields[f.at]) })),
            ...this.metrics.map((m) => element('td', { className: 'n', textContent: shown(p.metrics[m.at], m.unit) })),
          ),
        );
      }
      const words = points.length > kMostRows ? `The first ${kMostRows} of the ${points.length} chosen points` : 'The chosen points';
      this.list.replaceChildren(
        element(
          'table',
          {},
          element('caption', {}, element('span', { textContent: this.data.subject ? `${words}; ${this.data.subject}` : words })),
          element('thead', {}, head),
          body,
        ),
      );
      this.stackable(this.list.firstChild);
    }

    // Zoom and keys.

    zoom(factor) {
      if (!this.drawn.has('explore')) return;
      const { view } = this.drawn.get('explore');
      for (const [signal, name] of [
        ['grid_px', 'x'],
        ['grid_py', 'y'],
      ]) {
        const scale = view.scale(name);
        const [low, high] = scale.domain(),
          log = scale.type === 'log';
        const [a, b] = log ? [Math.log(low), Math.log(high)] : [low, high],
          half = ((b - a) / 2) * factor,
          middle = (a + b) / 2;
        const ends = [middle - half, middle + half];
        view.signal(signal, factor === null ? null : log ? ends.map(Math.exp) : ends);
      }
      view.runAsync();
    }
    zoom_to_chosen() {
      const points = this.on_chart.filter((p) => this.chosen === null || this.chosen.includes(p.id));
      if (points.length === 0 || !this.drawn.has('explore')) return;
      const { view } = this.drawn.get('explore'),
        how = this.picked('explore', 'how');
      ['grid_px', 'grid_py'].forEach((signal, i) => {
        const log = view.scale(i === 0 ? 'x' : 'y').type === 'log';
        view.signal(signal, scale_of(points.map(this.places[i].of), log ? 'log' : how === 'log' ? 'fitted' : 'linear').domain);
      });
      view.signal('brush_x', [0, 0]).signal('brush_y', [0, 0]).runAsync();
    }
    key(event) {
      if (event.ctrlKey || event.altKey || event.metaKey || !this.drawn.has('explore')) return;
      const at = this.on_chart.findIndex((p) => p.id === this.cursor),
        last = this.on_chart.length - 1;
      const go = (to) => this.point_at(this.on_chart[Math.max(0, Math.min(last, to))]);
      const actions = {
        ArrowRight: () => go(at + 1),
        ArrowLeft: () => go(at - 1),
        ArrowUp: () => go(at + 10),
        ArrowDown: () => go(at - 10),
        Home: () => go(0),
        End: () => go(last),
        '+': () => this.zoom(0.5),
        '=': () => this.zoom(0.5),
        '-': () => this.zoom(2),
        0: () => this.zoom(null),
        Escape: () => this.choose(null),
        Enter: () => {
          if (this.cursor === null) return;
          const own = this.chosen || [];
          this.choose(own.includes(this.cursor) ? own.filter((id) => id !== this.cursor) : [...own, this.cursor]);
        },
      };
      if (!actions[event.key]) return;
      event.preventDefault();
      actions[event.key]();
    }
    point_at(p) {
      if (!p) return;
      this.cursor = p.id;
      this.drawn.get('explore').view.signal('here', p.id).runAsync();
      this.read_out.textContent = this.tips(p)
        .filter(([, text]) => text !== '')
        .map(([title, text]) => (title === 'point' ? text : `${title} ${text}`))
        .join(' · ');
    }
  }

  Object.assign(Explorer.prototype, grtx_explore_charts.methods);
  return (embed, stackable) =>
    Promise.all([...document.querySelectorAll('.explorer')].map((box) => new Explorer(box, embed, stackable).redraw()));
})();
