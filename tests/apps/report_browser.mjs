// SPDX-License-Identifier: Apache-2.0
// Opens a report in Chromium without a screen and prints, as JSON, what a reader would find: drawn marks, the tooltip,
// what a box chooses, messages, requests, overflow. The test that runs it says what must hold.
//   node report_browser.mjs PAGE FOLDER_WITH_NODE_MODULES CHROMIUM [SCREENSHOT_PREFIX]
import { readFileSync, rmSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

import { emptyBrowser } from './empty_browser.mjs';

const [page_file, folder, chromium_path, prefix] = process.argv.slice(2);
const found = { messages: [], requests: [], overflow: {} };

const visit = async (context) => {
  const page = await context.newPage();
  page.on('console', (message) => found.messages.push(`${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => found.messages.push(`error: ${error.message}`));
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith('data:') && url !== pathToFileURL(page_file).href) found.requests.push(url);
  });
  await page.goto(pathToFileURL(page_file).href);
  return page;
};
const ready = (page) => page.waitForSelector('html[data-ready]', { timeout: 60000 });
const ids_of = (page, figure) =>
  page.evaluate((id) => [...document.querySelectorAll(`#${id} g.points_marks path`)].map((mark) => mark.__data__.datum.id), figure);
const shown_rows = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll('#sweep1_points tbody tr')].filter((row) => !row.hidden).map((row) => Number(row.dataset.id)),
  );
const bar_labels = (page, figure) =>
  page.evaluate(
    (id) => [...new Set([...document.querySelectorAll(`#${id} g.mark-rect.role-mark path`)].map((mark) => mark.__data__.datum.label))],
    figure,
  );

const marks = (page) => ids_of(page, 'sweep1_explore');
const axis_labels = (page) =>
  page.evaluate(() => [...document.querySelectorAll('#sweep1_explore g.role-axis-label text')].map((t) => t.textContent).sort());
const status = (page) => page.locator('.explorer .chosen').innerText();
const settle = (page) => page.waitForTimeout(400);

// Hover over a point that no other covers.
const hover = async (page) => {
  await page.locator('#sweep1_explore').scrollIntoViewIfNeeded();
  const over = await page.evaluate(() => {
    for (const mark of document.querySelectorAll('#sweep1_explore g.points_marks path')) {
      const box = mark.getBoundingClientRect();
      const at = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
      if (document.elementFromPoint(at.x, at.y) === mark) return { ...at, id: mark.__data__.datum.id };
    }
    return null;
  });
  await page.mouse.move(over.x - 3, over.y - 3);
  await page.mouse.move(over.x, over.y);
  await page.waitForSelector('#vg-tooltip-element.visible');
  found.hover = { id: over.id, text: await page.locator('#vg-tooltip-element').innerText() };
  if (prefix) await page.screenshot({ path: `${prefix}_hover.png` });
};

// A box around the left half of the chart, between two marks, so that none lies on the edge.
const brush = async (page) => {
  const half = await page.evaluate(() => {
    const at = [...document.querySelectorAll('#sweep1_explore g.points_marks path')].map((mark) => {
      const box = mark.getBoundingClientRect();
      return { id: mark.__data__.datum.id, x: box.x + box.width / 2, y: box.y + box.height / 2 };
    });
    const xs = at.map((m) => m.x).sort((a, b) => a - b),
      split = Math.floor(xs.length / 2);
    let edge = split;
    for (let i = split - 5; i < split + 5; i += 1) if (xs[i + 1] - xs[i] > xs[edge + 1] - xs[edge]) edge = i;
    const right = (xs[edge] + xs[edge + 1]) / 2,
      ys = at.map((m) => m.y);
    return {
      left: xs[0] - 8,
      right,
      top: Math.min(...ys) - 8,
      bottom: Math.max(...ys) + 8,
      inside: at.filter((m) => m.x < right).map((m) => m.id),
    };
  });
  await page.mouse.move(half.left, half.top);
  await page.mouse.down();
  await page.mouse.move((half.left + half.right) / 2, (half.top + half.bottom) / 2, { steps: 4 });
  await page.mouse.move(half.right, half.bottom, { steps: 4 });
  await page.mouse.up();
  await settle(page);
  found.box = {
    inside: half.inside,
    rows: await shown_rows(page),
    bars: await bar_labels(page, 'sweep1_stalls_bars'),
    status: await status(page),
    lines: await page.evaluate(
      () =>
        new Set(
          [...document.querySelectorAll('#sweep1_parallel g.mark-line.role-mark path')].map(
            (m) => m.__data__.datum.id ?? m.__data__.items?.[0]?.datum.id,
          ),
        ).size,
    ),
  };
  if (prefix) await page.screenshot({ path: `${prefix}_box.png` });
};

const zoom = async (page) => {
  const before = await axis_labels(page);
  await page.locator('#sweep1_explore button', { hasText: 'to chosen' }).click();
  await settle(page);
  const chosen = await axis_labels(page);
  await page.locator('#sweep1_explore button', { hasText: 'whole' }).click();
  await settle(page);
  const whole = await axis_labels(page);
  const drawing = await page.locator('#sweep1_explore svg').boundingBox();
  await page.mouse.move(drawing.x + drawing.width / 2, drawing.y + drawing.height / 2);
  await page.keyboard.down('Control');
  await page.mouse.wheel(0, -300);
  await page.keyboard.up('Control');
  await settle(page);
  const wheel = await axis_labels(page);
  await page.locator('#sweep1_explore button', { hasText: 'whole' }).click();
  await settle(page);
  found.zoom = { before, chosen, whole, wheel };
};

// From point to point by keys; Enter chooses, Escape ends.
const keyboard = async (page) => {
  await page.locator('#sweep1_explore .drawing').focus();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('ArrowRight');
  const text = await page.locator('#sweep1_explore .cursor').innerText();
  await page.keyboard.press('Enter');
  await settle(page);
  const rows = await shown_rows(page);
  const labels = await axis_labels(page);
  await page.keyboard.press('+');
  await settle(page);
  const zoomed = await axis_labels(page);
  await page.keyboard.press('0');
  await page.keyboard.press('Escape');
  await settle(page);
  found.keyboard = { text, rows, labels, zoomed, after: await status(page) };
};

const filter = async (page) => {
  const chip = page.locator('.filters fieldset', { hasText: /^k/ }).locator('input').first();
  await chip.uncheck();
  await settle(page);
  found.filter = { marks: await marks(page), rows: await shown_rows(page), status: await status(page) };
  await page.locator('.explorer .all').click();
  await settle(page);
};

const look_at_sweep = async (page) => {
  found.points = await marks(page);
  found.front = await page.evaluate(() =>
    [...document.querySelectorAll('#sweep1_explore g.points_marks path')]
      .filter((m) => m.__data__.datum.front)
      .map((m) => m.__data__.datum.id),
  );
  found.colours = await page.evaluate(
    () => new Set([...document.querySelectorAll('#sweep1_explore g.points_marks path')].map((mark) => mark.getAttribute('fill'))).size,
  );
  found.front_bars = await bar_labels(page, 'sweep1_stalls_bars');
  await hover(page);
  await brush(page);
  await zoom(page);
  await page.locator('.explorer .all').click();
  await settle(page);
  found.after_all = { rows: await shown_rows(page), bars: await bar_labels(page, 'sweep1_stalls_bars') };
  await keyboard(page);
  await filter(page);

  // By the last coordinate; behind it is "nothing".
  await page.locator('.explorer .colour').selectOption({ index: (await page.locator('.explorer .colour option').count()) - 2 });
  await settle(page);
  found.colours_by_last = await page.evaluate(
    () => new Set([...document.querySelectorAll('#sweep1_explore g.points_marks path')].map((mark) => mark.getAttribute('fill'))).size,
  );
  await page.locator('#sweep1_lines .key').selectOption({ index: 1 });
  await settle(page);
  found.lines_over = await page.evaluate(() =>
    [...document.querySelectorAll('#sweep1_lines g.role-axis-label text')].map((t) => t.textContent),
  );
  found.effects = await page.evaluate(() =>
    [...document.querySelectorAll('#sweep1_effects g.mark-symbol path')].map((m) => m.__data__.datum),
  );

  await page.locator('#sweep1_points thead button', { hasText: 'cycles' }).click();
  found.sorted = await page.evaluate(() => {
    const table = document.getElementById('sweep1_points');
    const column = [...table.tHead.rows[0].cells].findIndex((c) => c.textContent === 'cycles');
    return [...table.tBodies[0].rows].map((row) => Number(row.cells[column].textContent.replaceAll(',', '')));
  });
};

// Views of scenes: which marks and rows each shows, and speed-ups over another point.
const look_at_views = async (page) => {
  const state = async () => ({
    marks: await marks(page),
    rows: await shown_rows(page),
    axes: await axis_labels(page),
    bars: await page.evaluate(() => [
      ...new Set([...document.querySelectorAll('#sweep1_stalls_bars g.mark-rect.role-mark path')].map((mark) => mark.__data__.datum.id)),
    ]),
    speedups: await page.evaluate(() =>
      [...document.querySelectorAll('#sweep1_points tbody tr')]
        .filter((row) => !row.hidden)
        .map((row) => row.querySelector('.speedup').textContent),
    ),
  });
  found.titles = await page.evaluate(() => [...document.querySelectorAll('#sweep1_points thead th')].map((th) => th.textContent));
  found.views = [await state()];
  const views = page.locator('.explorer .view');
  for (let i = 1; i < (await views.locator('option').count()); i += 1) {
    await views.selectOption({ index: i });
    await settle(page);
    found.views.push(await state());
  }
  await page.locator('.explorer .reference').selectOption({ index: 1 });
  await settle(page);
  found.over_second = (await state()).speedups;
  await page.locator('#sweep1_explore .how').selectOption('zero');
  await settle(page);
  found.from_zero = await axis_labels(page);
  await page.locator('#sweep1_explore .how').selectOption('fitted');
  await views.selectOption({ index: 0 });
  await settle(page);
};

// The three files of the first chart.
const take_exports = async (page) => {
  found.exports = {};
  const place = page.locator('.export').first();
  for (const name of ['SVG', 'PNG', 'CSV']) {
    const [download] = await Promise.all([page.waitForEvent('download'), place.locator('button', { hasText: name }).click()]);
    const bytes = readFileSync(await download.path());
    found.exports[name] = {
      file: download.suggestedFilename(),
      begin: bytes.subarray(0, 4).toString('latin1'),
      bytes: bytes.length,
      variables: bytes.toString('latin1').includes('var('),
      first_line: name === 'CSV' ? bytes.toString('utf8').split('\n')[0] : '',
    };
  }
};

// Cells of stacked rows that do not name their column, or whose name covers their figure.
const unnamed_cells = (page) =>
  page.evaluate(() => {
    const cells = [...document.querySelectorAll('table.stacks tbody td:not(:empty)')].filter((cell) => cell.checkVisibility());
    const titles = (cell) => [...cell.closest('table').tHead.rows[0].cells].map((title) => title.textContent);
    const named = (cell) => getComputedStyle(cell, '::before').content === JSON.stringify(titles(cell)[cell.cellIndex]);
    return { cells: cells.length, unnamed: cells.filter((cell) => !named(cell)).map((cell) => cell.textContent) };
  });

// Figures and options in sentences of the answer that stand on two lines.
const broken_figures = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll('main p .whole')].filter((part) => part.getClientRects().length > 1).map((part) => part.textContent),
  );

// Texts of drawings that stand on each other, over an edge, or are cut. A text may have a halo, itself once more.
const unreadable = (page) =>
  page.evaluate(() => {
    const found = [];
    for (const svg of [...document.querySelectorAll('figure.chart svg')].filter((drawing) => drawing.checkVisibility())) {
      const edge = svg.getBoundingClientRect();
      const shown = (text) => text.textContent.trim() !== '' && Number(getComputedStyle(text).opacity) > 0;
      const texts = [...svg.querySelectorAll('text')].filter(shown).map((text) => ({ words: text.textContent, box: text.getBoundingClientRect() }));
      texts.forEach(({ words, box }, i) => {
        if (words.endsWith('…')) found.push(`cut: ${words}`);
        if (box.left < edge.left - 2 || box.right > edge.right + 2) found.push(`over the edge: ${words}`);
        for (const other of texts.slice(i + 1)) {
          const width = Math.min(box.right, other.box.right) - Math.max(box.left, other.box.left),
            height = Math.min(box.bottom, other.box.bottom) - Math.max(box.top, other.box.top);
          if (width > 2 && height > 4 && words !== other.words) found.push(`${words} on ${other.words}`);
        }
      });
    }
    return found;
  });

// Parts of bars that look alike in a chart, and those that have another colour in another chart.
const odd_colours = (page) =>
  page.evaluate(() => {
    const found = [],
      everywhere = new Map();
    const colour = ({ fill, stroke }) => (['none', 'transparent', 'rgba(0, 0, 0, 0)'].includes(fill) ? stroke : fill); // of lines
    for (const figure of document.querySelectorAll('figure.chart')) {
      const labels = [...figure.querySelectorAll('g.role-legend-label text')].map((text) => text.textContent);
      const fills = [...figure.querySelectorAll('g.role-legend-symbol path')].map((path) => colour(getComputedStyle(path)));
      labels.forEach((label, i) => {
        if (fills.indexOf(fills[i]) !== i) found.push(`${label} as ${labels[fills.indexOf(fills[i])]}`);
        const name = label.replace(/^memory: /, '').toLowerCase();
        if (figure.querySelector('g.mark-rect') === null) return;
        if (everywhere.has(name) && everywhere.get(name) !== fills[i]) found.push(`${label} in two colours`);
        everywhere.set(name, fills[i]);
      });
    }
    return found;
  });

// Boxes that scroll though they hold no more than a table of a screen or two.
const hiding_boxes = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll('.scroll')]
      .filter((box) => box.checkVisibility() && box.scrollHeight > box.clientHeight + 1 && box.querySelectorAll('tbody tr').length < 43)
      .map((box) => box.getAttribute('aria-label')),
  );

// Words of tables that stand on two lines.
const broken_words = (page) =>
  page.evaluate(() => {
    const broken = [];
    for (const cell of document.querySelectorAll('th, td')) {
      const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
      for (let node = walker.nextNode(); node; node = walker.nextNode()) {
        for (const { 0: word, index } of node.textContent.matchAll(/[\p{L}\p{N}_.]+/gu)) {
          const range = document.createRange();
          range.setStart(node, index);
          range.setEnd(node, index + word.length);
          const tops = new Set([...range.getClientRects()].map((box) => Math.round(box.top)));
          if (tops.size > 1) broken.push(word);
        }
      }
    }
    return broken;
  });

const { context, profile } = await emptyBrowser(folder, chromium_path);
try {
  const page = await visit(context);
  await ready(page);
  found.charts = await page.locator('figure.chart:not([hidden])').count();
  found.drawn_by_script = await page.evaluate(() => document.querySelectorAll('figure.chart .spec, .explorer').length);
  found.drawings = await page.locator('figure.chart svg').count();
  found.labelled = await page.evaluate(() =>
    [...document.querySelectorAll('figure.chart .drawing')].every((d) => d.getAttribute('aria-label')),
  );
  found.repeated_ids = await page.evaluate(() => {
    const ids = [...document.querySelectorAll('[id]')].map((e) => e.id);
    return ids.filter((id, i) => ids.indexOf(id) !== i);
  });
  found.tables = await page.locator('table').count();
  found.described_tables = await page.evaluate(
    () =>
      [...document.querySelectorAll('table')].filter(
        (t) => t.caption && t.caption.textContent && [...t.querySelectorAll('th')].every((th) => th.hasAttribute('scope')),
      ).length,
  );
  found.cut = await page.evaluate(() =>
    [...document.querySelectorAll('.card dd')].filter((d) => d.scrollHeight > d.clientHeight + 1).map((d) => d.textContent),
  );
  found.hiding_boxes = await hiding_boxes(page);
  found.unreadable = await unreadable(page);
  found.odd_colours = await odd_colours(page);
  if ((await page.locator('.export').count()) > 0) await take_exports(page);
  if ((await page.locator('.explorer .view').count()) === 1) await look_at_views(page);
  else if ((await page.locator('#sweep1_explore').count()) === 1) await look_at_sweep(page);
  if (prefix) await page.screenshot({ path: `${prefix}_1280.png`, fullPage: true });
  await page.emulateMedia({ colorScheme: 'dark' });
  if (prefix) await page.screenshot({ path: `${prefix}_1280_dark.png`, fullPage: true });
  await page.emulateMedia({ colorScheme: 'light' });
  found.overflow[1280] = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

  // A sheet of A4 without its margins.
  await page.emulateMedia({ media: 'print' });
  await page.setViewportSize({ width: 703, height: 1000 });
  found.overflow.print = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  await page.emulateMedia({ media: 'screen' });
  await page.setViewportSize({ width: 1280, height: 900 });

  const pdf = await page.pdf({ format: 'A4' });
  found.pdf = { begin: pdf.subarray(0, 5).toString('latin1'), bytes: pdf.length };

  const small = await visit(context);
  await small.setViewportSize({ width: 390, height: 844 });
  await small.reload();
  await ready(small);
  found.overflow[390] = await small.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  found.wide_drawings = await small.evaluate(() =>
    [...document.querySelectorAll('figure.chart:not([hidden])')]
      .filter((f) => {
        const svg = f.querySelector('svg').getBoundingClientRect();
        return svg.right > f.getBoundingClientRect().right + 1;
      })
      .map((f) => f.id),
  );
  found.broken_words = await broken_words(small);
  found.broken_figures = await broken_figures(small);
  found.whole_figures = await small.evaluate(() => [...document.querySelectorAll('main p .whole')].map((part) => part.textContent));
  found.stacked = await unnamed_cells(small);
  found.unreadable.push(...(await unreadable(small)));
  found.hiding_boxes.push(...(await hiding_boxes(small)));
  if (prefix) await small.screenshot({ path: `${prefix}_390.png`, fullPage: true });

  const background = () => small.evaluate(() => getComputedStyle(document.body).backgroundColor);
  found.light = await background();
  await small.emulateMedia({ colorScheme: 'dark' });
  found.dark = await background();
  if (prefix) await small.screenshot({ path: `${prefix}_390_dark.png`, fullPage: true });

  const plain_context = await context.browser()?.newContext({ javaScriptEnabled: false });
  if (plain_context) {
    const plain = await visit(plain_context);
    found.plain = {
      tables: await plain.locator('table').count(),
      rows: await plain.locator('#sweep1_points tbody tr').count(),
      notes: await plain.locator('figure.chart noscript, .explorer noscript').count(),
      svgs: await plain.locator('figure.chart svg').count(),
      text: (await plain.locator('main').innerText()).length,
    };
  }
} finally {
  await context.close();
  rmSync(profile, { recursive: true, force: true });
}
process.stdout.write(JSON.stringify(found));
