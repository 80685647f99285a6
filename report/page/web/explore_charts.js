// SPDX-License-Identifier: Apache-2.0
// The Vega-Lite specifications of an explorer, as methods of the class in explore.js.
'use strict';

const grtx_explore_charts = (() => {
  const kBarPixels = 20; // as in charts.cpp
  const kMostBars = 24,
    kMostTips = 5,
    kMostColours = 12;
  const kWide = 20; // an axis whose values span more is logarithmic

  // Numbers.

  const kPrefixes = ['p', 'n', 'µ', 'm', '', 'k', 'M', 'G', 'T'];
  const has_prefix = (unit) => ['s', 'J', 'B'].includes(unit);
  const shown = (value, unit) => {
    if (value === null || value === undefined || !Number.isFinite(value)) return '';
    if (unit === '×') return `${value.toFixed(value < 0.1 ? 4 : 2)}×`;
    if (unit === '%') return `${value.toFixed(1)} %`;
    if (!has_prefix(unit) || value === 0)
      return `${Number(value.toPrecision(4)).toLocaleString('en', { maximumFractionDigits: 6 })} ${unit}`.trim();
    const place = Math.max(-4, Math.min(4, Math.floor(Math.log10(Math.abs(value)) / 3)));
    return `${Number((value / 1000 ** place).toPrecision(4))} ${kPrefixes[place + 4]}${unit}`;
  };
  const label_expression = (unit) => {
    if (has_prefix(unit)) return `replace(format(datum.value, '.3~s'), /([a-zA-Zµ]?)$/, ' $1') + '${unit}'`;
    if (unit === '×' || unit === '%') return `format(datum.value, '.4~r') + '${unit === '%' ? ' %' : unit}'`;
    return "abs(datum.value) < 1000 ? format(datum.value, '.4~r') : format(datum.value, '.3~s')";
  };
  const mean = (values) => Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length);
  const average = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;
  /// Labels of the front that do not cover each other: the first of points that are equal stands for all of them.
  const apart = (rows, scales) => {
    const place = (scale, value) => {
      const [low, high] = scale.domain.map(scale.type === 'log' ? Math.log : Number);
      return ((scale.type === 'log' ? Math.log(value) : value) - low) / (high - low);
    };
    const taken = [];
    return rows
      .filter((row) => row.front && row.rank === 0)
      .filter((row) => {
        const at = [place(scales[0], row.px), place(scales[1], row.py)];
        if (taken.some((other) => Math.abs(other[0] - at[0]) < 0.09 && Math.abs(other[1] - at[1]) < 0.06)) return false;
        taken.push(at);
        row.left = at[0] > 0.75; // of its mark, not over the chart's edge
        return true;
      });
  };
  /// Names of values on a line that would cover each other, as one: "8, 16". pixels: of the line.
  const joined = (rows, scale, pixels) => {
    const found = [];
    const [low, high] = scale.domain.map(scale.type === 'log' ? Math.log : Number);
    const width = (label) => (6.5 * (label.value.length + 1)) / pixels;
    for (const row of [...rows].sort((a, b) => a.factor - b.factor)) {
      const at = ((scale.type === 'log' ? Math.log(row.factor) : row.factor) - low) / (high - low);
      let label = { key: row.key, factor: row.factor, value: row.value, at };
      for (let last = found.at(-1); last && label.at - last.at < (width(label) + width(last)) / 2; last = found.at(-1)) {
        label = { ...label, value: `${last.value}, ${label.value}`, factor: (last.factor + label.factor) / 2, at: (last.at + label.at) / 2 };
        found.pop();
      }
      found.push(label);
    }
    return found.map((label) => ({ ...label, side: label.at < width(label) / 2 ? 'left' : label.at > 1 - width(label) / 2 ? 'right' : 'center' }));
  };
  /// Colour of a thing by its name in report.css, as in charts.cpp.
  const named = (kind, name, otherwise) => `var(--${kind}-${String(name).replace(/[^A-Za-z0-9_]/g, '-')}, ${otherwise})`;
  const by_size = (a, b) => (typeof a === 'number' && typeof b === 'number' ? a - b : 0);

  /// Scale fitted to the values; how: "fitted", "zero" or "log".
  const scale_of = (values, how) => {
    let low = Math.min(...values),
      high = Math.max(...values);
    if (low > 0 && (how === 'log' || (how === 'fitted' && high > kWide * low))) {
      const margin = low === high ? 1.5 : (high / low) ** 0.05;
      return { type: 'log', domain: [low / margin, high * margin], nice: false };
    }
    if (how === 'zero') [low, high] = [Math.min(0, low), Math.max(0, high)];
    const margin = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
    const from = how === 'zero' && low === 0 ? 0 : low >= 0 ? Math.max(0, low - margin) : low - margin;
    return { type: 'linear', domain: [from, high + margin], nice: false, zero: false };
  };
  const frame = (rows, height) => ({
    width: 'container',
    height,
    autosize: { type: 'fit-x', contains: 'padding' },
    data: { values: rows },
  });
  const axis_of = (field, title, unit, scale) => ({
    field,
    type: 'quantitative',
    title: unit.startsWith('mm') ? `${title}, ${unit}` : title,
    scale,
    axis: { labelExpr: label_expression(unit) },
  });

  const key_axis = (key, wanted) => {
    if (!key.numeric) return { field: 'key', type: 'ordinal', title: key.title, sort: wanted, axis: { labelAngle: 0 } };
    const last = wanted[wanted.length - 1],
      type = wanted[0] > 0 && last >= 8 * wanted[0] ? 'log' : 'linear';
    const scale = { type, domain: [wanted[0], last], nice: false, padding: 12 };
    return {
      field: 'key',
      type: 'quantitative',
      title: key.title,
      scale,
      axis: { values: wanted, labelExpr: "format(datum.value, ',')", grid: false },
    };
  };

  const methods = {
    design_colour(design) {
      return named('d', design, 'var(--c10)');
    },

    colour_encoding() {
      const field = this.colour_field;
      if (field === null) return { value: 'var(--c1)' };
      if (field.numeric && field.values.length > kMostColours) {
        return { field: 'colour', type: 'quantitative', scale: { scheme: 'viridis' }, legend: { title: field.title, orient: 'bottom' } };
      }
      const range =
        field.title === 'design'
          ? field.values.map((d) => this.design_colour(d))
          : field.values.map((v, i) => `var(--c${(i % kMostColours) + 1})`);
      return {
        field: 'colour',
        type: 'nominal',
        scale: { domain: field.values.map(String), range },
        legend: { title: field.title, orient: 'bottom' },
      };
    },
    colour_of(p) {
      const field = this.colour_field;
      if (field === null) return '';
      return field.numeric && field.values.length > kMostColours ? p.fields[field.at] : String(p.fields[field.at]);
    },

    /// What sets a point apart, and its figures, as texts.
    tips(p) {
      const list = [['point', p.label]];
      if (this.fields.length <= kMostTips)
        for (const f of this.fields) list.push([f.title, p.fields[f.at] === null ? '' : String(p.fields[f.at])]);
      else list.push(['differs in', p.name]);
      for (const m of this.metrics.slice(0, 3)) list.push([m.title, shown(p.metrics[m.at], m.unit)]);
      if (p.interval) list.push(['95 % interval of the time', p.interval.map((v) => shown(v, 's')).join(' to ')]);
      if (this.speedup && p.reference && p.reference !== p)
        list.push(['speed-up', `${this.speedup_text(p).join('')} over ${p.reference.label}`]);
      if (p.notes) list.push(['mind', p.notes]);
      return list;
    },
    tip_fields(points) {
      const titles = [];
      for (const p of points) for (const [title] of this.tips(p)) if (!titles.includes(title)) titles.push(title);
      return titles;
    },
    tip_row(p, titles) {
      return Object.fromEntries(this.tips(p).map(([title, text]) => [`t${titles.indexOf(title)}`, text]));
    },

    /// Ids of the points that no other beats in both quantities.
    front(points, x, y) {
      if (x.field || y.field) return new Set();
      const sign = (q) => (q.more ? -1 : 1);
      const sorted = [...points].sort((a, b) => sign(x) * (x.of(a) - x.of(b)) || sign(y) * (y.of(a) - y.of(b)));
      const on = new Set();
      let best = Infinity,
        at = NaN;
      for (const p of sorted) {
        const own = sign(y) * y.of(p);
        if (own < best || (own === best && x.of(p) === at)) {
          on.add(p.id);
          [best, at] = [own, x.of(p)];
        }
      }
      return on;
    },

    explore_spec() {
      const [x, y] = [this.quantity(this.picked('explore', 'x')), this.quantity(this.picked('explore', 'y'))];
      const points = this.kept().filter((p) => Number.isFinite(x.of(p)) && Number.isFinite(y.of(p)));
      this.front_ids = this.front(points, x, y);
      this.on_chart = points.sort((a, b) => x.of(a) - x.of(b));
      this.places = [x, y];
      if (points.length === 0) return null;
      const how = this.picked('explore', 'how'),
        titles = this.tip_fields(points);
      const rows = points.map((p) => {
        const row = { id: p.id, label: p.label, px: x.of(p), py: y.of(p), colour: this.colour_of(p), front: this.front_ids.has(p.id) };
        return { ...row, ...this.tip_row(p, titles) };
      });
      // Of points in one place the first is a mark, the others are rings around it.
      const places = new Map();
      for (const row of rows) {
        const same = places.get(`${row.px} ${row.py}`) || [];
        row.rank = same.length;
        row.size = (row.front ? 120 : 45) * (1 + 0.9 * Math.min(row.rank, 6));
        places.set(`${row.px} ${row.py}`, [...same, row.label]);
      }
      for (const row of rows) {
        const same = places.get(`${row.px} ${row.py}`);
        row.words = same.slice(0, 3).join(' = ') + (same.length > 3 ? ` and ${same.length - 3} more` : '');
      }
      const limits = [x.limit, y.limit];
      const scales = [x, y].map((q, i) => scale_of([...points.map(q.of), ...(Number.isFinite(limits[i]) ? [limits[i]] : [])], how));
      const place = {
        x: axis_of('px', x.title, x.unit, scales[0]),
        y: axis_of('py', y.title, y.unit, scales[1]),
      };
      const steps = {
        type: 'line',
        interpolate: x.more ? 'step-before' : 'step-after',
        color: 'var(--muted)',
        strokeDash: [4, 3],
        clip: true,
      };
      const line = { transform: [{ filter: 'datum.front' }], encoding: { ...place, order: { field: 'px' } }, mark: steps };
      const limit = (channel, value) => [
        {
          data: { values: [{ [`p${channel}`]: value }] },
          mark: { type: 'rule', color: 'var(--bad)', strokeWidth: 1.5, clip: true },
          encoding: { [channel]: place[channel] },
        },
      ];
      const names = {
        data: { values: apart(rows, scales) },
        mark: { type: 'text', align: { expr: "datum.left ? 'right' : 'left'" }, dx: { expr: 'datum.left ? -8 : 8' }, dy: -8, fontSize: 11 },
        encoding: { ...place, text: { field: 'words' } },
      };
      const layer = [
        ...(this.front_ids.size > 0 ? [line] : []),
        ...['x', 'y'].flatMap((channel, i) => (Number.isFinite(limits[i]) ? limit(channel, limits[i]) : [])),
        this.explore_marks(place, titles),
        ...(this.front_ids.size > 0 ? [names] : []),
      ];
      return {
        ...frame(rows, 360),
        params: [
          { name: 'picked', value: null },
          { name: 'here', value: null },
        ],
        layer,
      };
    },

    /// A box by dragging; with Shift it moves what is shown, with Ctrl the wheel zooms.
    explore_marks(place, titles) {
      const drag = (test) => `[pointerdown[${test}], window:pointerup] > window:pointermove!`;
      const box = { type: 'interval', on: drag('!event.shiftKey'), translate: drag('!event.shiftKey'), zoom: false };
      const grid = { type: 'interval', zoom: 'wheel![event.ctrlKey || event.metaKey]', translate: drag('event.shiftKey') };
      const at_cursor = (value) => ({ test: 'datum.id === here', value });
      return {
        name: 'points',
        params: [
          { name: 'brush', select: box },
          { name: 'grid', select: grid, bind: 'scales' },
        ],
        mark: { type: 'point', filled: true, clip: true },
        encoding: {
          ...place,
          color: this.colour_encoding(),
          size: { condition: at_cursor(220), field: 'size', type: 'quantitative', scale: null, legend: null },
          fillOpacity: { condition: { test: 'datum.rank > 0', value: 0 }, value: 1 },
          stroke: { condition: [at_cursor('var(--ink)'), { test: 'datum.rank > 0', value: 'var(--ink)' }], value: 'var(--card)' },
          strokeWidth: { condition: [at_cursor(3), { test: 'datum.rank > 0', value: 1.2 }], value: 0.5 },
          opacity: { condition: { test: 'picked === null || indexof(picked, datum.id) >= 0', value: 0.9 }, value: 0.1 },
          tooltip: titles.map((title, i) => ({ field: `t${i}`, title })),
        },
      };
    },

    /// Points in groups that differ in one key alone: [{points: Map(value -> point)}].
    groups(key) {
      const groups = new Map();
      for (const p of this.kept()) {
        if (p.fields[key.at] === null) continue;
        const rest = JSON.stringify([p.base, p.design, ...p.fields.map((v, i) => (i === key.at ? null : v))]);
        if (!groups.has(rest)) groups.set(rest, new Map());
        groups.get(rest).set(p.fields[key.at], p);
      }
      return [...groups.values()].filter((group) => group.size > 1);
    },

    lines_spec() {
      const key = this.fields.find((f) => f.at === Number(this.picked('lines', 'key'))),
        chosen = this.picked('lines', 'series');
      const y = this.quantity(this.picked('lines', 'metric'));
      const series = chosen === 'none' || Number(chosen) === key.at ? null : this.fields.find((f) => f.at === Number(chosen));
      const wanted = key.values.filter((v) => this.kept().some((p) => p.fields[key.at] === v));
      const { thin, thick } = this.line_rows(key, y, (p) => (series === null ? 'all' : String(p.fields[series.at])), wanted);
      if (thin.length === 0) return null;
      const names = series === null ? ['all'] : series.values.map(String),
        title = series === null ? 'points' : series.title;
      const range = names.map((n, i) => (title === 'design' ? this.design_colour(n) : `var(--c${(i % kMostColours) + 1})`));
      const legend = series === null ? null : { title, orient: 'bottom' };
      const encoding = {
        x: key_axis(key, wanted),
        y: axis_of(
          'value',
          y.title,
          y.unit,
          scale_of(
            thin.map((row) => row.value),
            'fitted',
          ),
        ),
        color: { field: 'series', type: 'nominal', scale: { domain: names, range }, legend },
      };
      const layer = [{ mark: { type: 'line', opacity: 0.45, strokeWidth: 1 }, encoding: { ...encoding, detail: { field: 'group' } } }];
      if (thick.length > 0) {
        const tooltip = [
          { field: 'series', title },
          { field: 'key', title: key.title },
          { field: 'text', title: y.title },
        ];
        const mark = { type: 'line', strokeWidth: 3, point: { size: 60, filled: true } };
        layer.push({ data: { values: thick }, mark, encoding: { ...encoding, tooltip } });
      }
      return { ...frame(thin, 280), layer };
    },

    /// thin: a line a group; thick: the geometric mean of those groups of a series that have all wanted values; of
    /// shares, which may be 0, the arithmetic one.
    line_rows(key, y, series_of, wanted) {
      const share = y.unit === '%';
      const thin = [],
        means = new Map();
      this.groups(key).forEach((group, place) => {
        const series = series_of([...group.values()][0]);
        for (const [value, p] of group) if (Number.isFinite(y.of(p))) thin.push({ key: value, value: y.of(p), series, group: place });
        const counts = (value) => value > 0 || (share && value === 0);
        if (wanted.every((v) => group.has(v) && counts(y.of(group.get(v))))) means.set(series, [...(means.get(series) || []), group]);
      });
      const thick = [...means].flatMap(([series, groups]) =>
        wanted.map((v) => {
          const value = (share ? average : mean)(groups.map((group) => y.of(group.get(v))));
          return { key: v, series, value, text: `${shown(value, y.unit)}, mean of ${groups.length}` };
        }),
      );
      return { thin, thick };
    },

    effects_spec() {
      const y = this.quantity(this.picked('effects', 'metric')),
        alike = this.picked('effects', 'alike');
      const rows = [],
        drawn = [];
      for (const key of this.keys) {
        const groups = this.groups(key).filter((group) => alike === '' || this.alike_name([...group.values()][0]) === alike);
        const values = key.values.filter((v) => groups.some((group) => group.has(v)));
        for (const value of values) {
          const pairs = groups.filter((group) => group.has(values[0]) && group.has(value));
          const factors = pairs
            .map((group) => y.of(group.get(value)) / y.of(group.get(values[0])))
            .filter((f) => f > 0 && Number.isFinite(f));
          if (factors.length === 0) continue;
          rows.push({
            key: key.title,
            value: String(value),
            factor: mean(factors),
            of: factors.length,
            low: Math.min(...factors),
            high: Math.max(...factors),
          });
          if (!drawn.includes(key.title)) drawn.push(key.title);
        }
      }
      if (rows.length === 0) return null;
      const scale = scale_of(
        rows.map((row) => row.factor),
        'fitted',
      );
      const place = {
        y: { field: 'key', type: 'nominal', title: null, sort: drawn },
        x: axis_of('factor', `factor on ${y.title}`, '×', scale),
      };
      return {
        ...frame(rows, 40 * drawn.length),
        layer: [
          { mark: { type: 'line', color: 'var(--muted)' }, encoding: { ...place, detail: { field: 'key' } } },
          {
            mark: { type: 'point', filled: true, size: 70, color: 'var(--c1)' },
            encoding: {
              ...place,
              tooltip: [
                { field: 'key' },
                { field: 'value' },
                { field: 'factor', type: 'quantitative', format: '.3f' },
                { field: 'low', title: 'least', type: 'quantitative', format: '.3f' },
                { field: 'high', title: 'largest', type: 'quantitative', format: '.3f' },
                { field: 'of', title: 'pairs' },
              ],
            },
          },
          {
            data: { values: drawn.flatMap((key) => joined(rows.filter((row) => row.key === key), scale, this.box.clientWidth - 190)) },
            mark: { type: 'text', dy: -11, fontSize: 11, align: { expr: 'datum.side' } },
            encoding: { ...place, text: { field: 'value' } },
          },
        ],
      };
    },

    /// Axes stand side by side; on a phone they lie below each other.
    parallel_spec() {
      const points = this.kept(),
        axes = this.parallel_axes(points),
        narrow = this.box.clientWidth < 600;
      if (points.length < 2 || axes.length < 2) return null;
      const rows = [],
        marks = [];
      axes.forEach(({ title, values, of, text, height }, place) => {
        values.forEach((value, i) => {
          marks.push({ axis: title, v: height(value), text: text(value), below: values.length > 2 && i % 2 === 1 });
        });
        for (const p of points) {
          const v = height(of(p));
          if (Number.isFinite(v)) rows.push({ id: p.id, label: `${p.label} ${p.name}`, axis: title, v, place, colour: this.colour_of(p) });
        }
      });
      const labels = {
        labelAngle: 0,
        labelExpr: "indexof(datum.label, '.') < 0 ? datum.label : split(datum.label, /[._]| \\/ /)",
        domain: false,
        ticks: false,
        labelOverlap: false,
      };
      const across = {
        field: 'axis',
        type: 'ordinal',
        sort: axes.map((axis) => axis.title),
        title: null,
        scale: { type: 'point', padding: narrow ? 0.5 : 0.75 },
        axis: narrow ? labels : { ...labels, orient: 'bottom' },
      };
      const along = { field: 'v', type: 'quantitative', axis: null, scale: { domain: [-0.03, 1.03], nice: false } };
      const place = narrow ? { x: along, y: across } : { x: across, y: along };
      const faint = Math.max(0.12, Math.min(0.7, 40 / points.length)),
        chosen = 'picked !== null && indexof(picked, datum.id) >= 0';
      const lines = {
        transform: [{ filter: 'picked === null || indexof(picked, datum.id) >= 0' }],
        mark: { type: 'line', strokeWidth: 1.3 },
        encoding: {
          ...place,
          order: { field: 'place' },
          detail: { field: 'id' },
          color: { ...this.colour_encoding(), legend: null },
          opacity: { condition: { test: chosen, value: 0.9 }, value: faint },
          tooltip: [{ field: 'label', title: 'point' }],
        },
      };
      const at = narrow
        ? { align: { expr: "datum.v < 0.2 ? 'left' : datum.v > 0.8 ? 'right' : 'center'" }, dy: { expr: 'datum.below ? 12 : -9' } }
        : { align: 'left', dx: 4 };
      const words = (more) => ({
        data: { values: marks },
        mark: { type: 'text', fontSize: 11, ...at, ...more },
        encoding: { ...place, text: { field: 'text' } },
      });
      const rules = { data: { values: marks }, mark: { type: 'rule', color: 'var(--muted)' }, encoding: narrow ? { y: across } : { x: across } };
      const layer = [rules, lines, words({ stroke: 'var(--card)', strokeWidth: 3 }), words({})];
      return { ...frame(rows, narrow ? 64 * axes.length : 300), params: [{ name: 'picked', value: null }], layer };
    },

    /// Axes from 0 to 1: keys by the order of their values, metrics by what they span.
    parallel_axes(points) {
      const several = (f) => points.some((p) => p.fields[f.at] !== points[0].fields[f.at]);
      const axes = this.fields
        .filter(several)
        .slice(0, 8)
        .map((f) => {
          const { values } = f,
            last = values.length - 1;
          const height = (value) => (values.includes(value) ? values.indexOf(value) / last : NaN);
          return {
            title: f.title,
            of: (p) => p.fields[f.at],
            values: values.length <= 8 ? values : [values[0], values[last]],
            text: String,
            height,
          };
        });
      for (const m of this.metrics.slice(0, 3)) {
        const found = points.map((p) => p.metrics[m.at]).filter(Number.isFinite);
        if (found.length === 0) continue;
        const [low, high] = [Math.min(...found), Math.max(...found)],
          log = scale_of(found, 'fitted').type === 'log';
        const height = (value) => (low === high ? 0.5 : log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
        axes.push({ title: m.title, of: (p) => p.metrics[m.at] ?? NaN, values: [low, high], text: (v) => shown(v, m.unit), height });
      }
      return axes;
    },

    stalls_bars_spec() {
      return this.bars_spec('stalls', 'cycles of all RT units', '');
    },
    energy_bars_spec() {
      return this.bars_spec('energy', 'energy', 'J');
    },
    bars_spec(name, title, unit) {
      const ids = this.chosen === null ? this.front_ids : new Set(this.chosen);
      const points = this.kept()
        .filter((p) => ids.has(p.id))
        .sort((a, b) => a.metrics[0] - b.metrics[0])
        .slice(0, kMostBars);
      const parts = this.data[name],
        rows = [];
      points.forEach((p, order) => {
        const label = `${p.label} ${this.fields.map((f) => p.fields[f.at]).join(' · ')}`.trim();
        parts.forEach((part, place) => {
          const value = p[name][place];
          if (value > 0) rows.push({ id: p.id, label, order, part, place, value, shown: shown(value, unit) });
        });
      });
      if (rows.length === 0) return null;
      const range = parts.map((part, i) => named('p', part, `var(--c${(i % kMostColours) + 1})`));
      // On a phone a long name takes two lines.
      const narrow = this.box.clientWidth < 600;
      const two_lines = { labelExpr: "split(replace(datum.label, ' · ', '\\n'), '\\n')", labelLineHeight: 11 };
      return {
        ...frame(rows, (narrow ? 1.4 : 1) * kBarPixels * new Set(rows.map((row) => row.id)).size),
        mark: 'bar',
        encoding: {
          y: { field: 'label', type: 'nominal', title: null, sort: { field: 'order', op: 'min' }, axis: narrow ? two_lines : {} },
          x: { ...axis_of('value', title, unit), stack: 'zero' },
          order: { field: 'place' },
          color: { field: 'part', type: 'nominal', scale: { domain: parts, range }, legend: { title: null, orient: 'bottom' } },
          tooltip: [{ field: 'label', title: 'of' }, { field: 'part' }, { field: 'shown', title }],
        },
      };
    },
  };

  return { methods, shown, scale_of, by_size, kMostBars };
})();
