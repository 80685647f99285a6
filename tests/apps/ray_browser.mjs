// SPDX-License-Identifier: Apache-2.0
// Opens a page of grtx ray in Chromium without a screen, steps through it by keyboard and prints, as JSON, what a reader
// would find. The test that runs it says what must hold.
//   node ray_browser.mjs PAGE FOLDER_WITH_NODE_MODULES CHROMIUM [SCREENSHOT_PREFIX]
import { rmSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

import { emptyBrowser } from './empty_browser.mjs';

const [page_file, folder, chromium_path, prefix] = process.argv.slice(2);
const found = { messages: [], requests: [], overflow: {}, rounds: [] };

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
const ready = (page) => page.waitForSelector('html[data-ready]', { timeout: 120000 });

// What the page shows now; of long lists the rows in sight.
const state = (page) =>
  page.evaluate(() => {
    const rows = (id) => [...document.querySelectorAll(`#${id} .row`)].filter((row) => !row.textContent.includes('empty'));
    const hits = (id) => rows(id).map((row) => [Number(row.dataset.gaussian), Number(row.dataset.t)]);
    const nodes = (id) => rows(id).map((row) => `${row.dataset.node} ${row.children[2].textContent}`);
    const note = (id) => document.querySelector(`#${id} h2 span`).textContent;
    return {
      where: document.querySelector('.where').textContent,
      text: document.querySelector('#event').innerText,
      t_max: Number(document.querySelector('#t_max')?.dataset.t),
      k_buffer: hits('k_buffer'),
      evictions: hits('evictions'),
      source: nodes('source'),
      taken: document.querySelectorAll('#source .gone').length,
      destination: nodes('destination'),
      stack: nodes('stack'),
      sizes: { evictions: note('evictions'), source: note('source'), destination: note('destination'), stack: note('stack') },
    };
  });
const press = async (page, key, times = 1) => {
  for (let i = 0; i < times; i += 1) await page.keyboard.press(key);
};
const drawn = (page, selector) =>
  page.evaluate((at) => {
    const canvas = document.querySelector(at);
    if (!canvas || canvas.offsetParent === null) return null;
    const picture = canvas.toDataURL();
    const empty = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height }).toDataURL();
    return picture === empty ? null : picture.slice(-4000);
  }, selector);

const { context, profile } = await emptyBrowser(folder, chromium_path);
try {
  const page = await visit(context);
  await ready(page);
  await page.waitForFunction(() => document.querySelector('.story').textContent !== '');
  await page.waitForTimeout(300);
  found.story = await page.locator('.story').innerText();
  found.opened = await state(page);
  await press(page, 'Home');
  found.pixel = await page.locator('.pixel').innerText();
  found.along = await drawn(page, '.hits canvas');
  if (found.along !== null) {
    await page.locator('.hits canvas').focus();
    await press(page, 'ArrowRight');
    found.first_hit = { text: await page.locator('.hits .note').innerText(), state: await state(page) };
    await page.evaluate(() => document.activeElement.blur());
    await press(page, 'Home');
  }
  found.first = await state(page);
  found.hits = [];
  for (let i = 0; i < 5; i += 1) {
    await press(page, 'n');
    found.hits.push(await state(page));
  }
  found.view = await drawn(page, '.view3d canvas');
  found.axis = await drawn(page, '.axis canvas');
  if (found.axis !== null) {
    const axis_label = () => page.locator('.axis canvas').getAttribute('aria-label');
    found.axis_labels = [await axis_label()];
    for (let i = 0; i < 2; i += 1) {
      await page.locator('.axis button').click();
      found.axis_labels.push(await axis_label());
      if (i === 0) found.axis_near = await drawn(page, '.axis canvas');
    }
    await page.evaluate(() => document.activeElement.blur());
  }
  if (prefix) await page.screenshot({ path: `${prefix}_1280.png`, fullPage: true });
  if (found.view !== null) {
    await page.locator('.view3d canvas').focus();
    await press(page, 'ArrowRight', 3);
  }
  found.turned = await drawn(page, '.view3d canvas');
  found.after_turning = (await state(page)).where;
  await page.evaluate(() => document.activeElement.blur());

  // The end of each round, as far as 12 of them, and the beginning of the next.
  await press(page, 'Home');
  const rounds = await page.evaluate(() => JSON.parse(document.getElementById('page').textContent).rays[0].rounds.length);
  for (let r = 0; r < Math.min(rounds, 12); r += 1) {
    const begin = await state(page);
    await press(page, ']');
    let end = null;
    if (r + 1 < rounds) {
      await press(page, 'ArrowLeft');
      end = await state(page);
      await press(page, 'ArrowRight');
    } else {
      await press(page, 'End');
      end = await state(page);
    }
    found.rounds.push({ begin, end });
  }
  await press(page, 'Home');
  found.home = (await state(page)).where;
  await press(page, 'ArrowRight', 2);
  found.second = (await state(page)).where;
  await press(page, 'ArrowLeft');
  found.back = (await state(page)).where;

  // Finding: a Gaussian that was hit, and the node of the first event.
  const [gaussian] = found.hits[0].k_buffer.length > 0 ? found.hits[0].k_buffer[0] : [-1];
  for (const [name, text] of [
    ['gaussian', String(gaussian)],
    ['node', await page.evaluate(() => document.querySelector('#event .what').textContent.match(/0x[0-9a-f]+/)[0])],
    ['nothing', '0x3'],
  ]) {
    await press(page, '/');
    await page.keyboard.insertText(text);
    await press(page, 'Enter');
    await page.waitForFunction(() => / about /.test(document.querySelector('.where').textContent), null, { timeout: 60000 });
    found[`find_${name}`] = await state(page);
    await page.locator('input[type=search]').fill('');
    await press(page, 'Escape');
  }

  // Playing goes on by itself, and stops.
  await press(page, 'Home');
  await press(page, ' ');
  await page.waitForFunction(() => Number(document.querySelector('input[type=range]').value) >= 2, null, { timeout: 20000 });
  await press(page, ' ');
  found.playing = await page.evaluate(() => document.querySelector('.bar-of-tools').textContent.includes('pause'));

  // By the rows of a round: down two, and what is folded opens with Enter.
  await press(page, 'Home');
  await page.locator('.round .list').first().focus();
  await press(page, 'ArrowDown', 2);
  found.down = (await state(page)).where;
  const folds = () => page.evaluate(() => document.querySelectorAll('.round:first-child .row.fold').length);
  found.folds = await folds();
  await page.locator('.bar-of-tools select').last().selectOption('0');
  found.unfolded = await folds();
  found.elements = await page.evaluate(() => document.querySelectorAll('#player *').length);
  found.columns = await page.locator('.round').count();
  found.repeated_ids = await page.evaluate(() => {
    const ids = [...document.querySelectorAll('[id]')].map((e) => e.id);
    return ids.filter((id, i) => ids.indexOf(id) !== i);
  });
  found.cut_rows = await page.evaluate(() =>
    [...document.querySelectorAll('.state .row span, .round header')]
      .filter((e) => e.offsetParent !== null && (e.scrollWidth > e.clientWidth + 1 || e.scrollHeight > e.clientHeight + 3) && e.clientWidth > 0)
      .map((e) => e.textContent),
  );
  found.labelled = await page.evaluate(() =>
    [...document.querySelectorAll('#player button, #player input, #player select, #player canvas, #player [tabindex="0"]')].every(
      (e) => e.getAttribute('aria-label') || e.offsetParent === null,
    ),
  );
  found.overflow[1280] = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

  const small = await visit(context);
  await small.setViewportSize({ width: 390, height: 844 });
  await small.reload();
  await ready(small);
  await press(small, 'Home');
  await press(small, 'n', 5);
  found.small = (await state(small)).where;
  found.cut_tables = await small.evaluate(() =>
    [...document.querySelectorAll('main > .scroll')].filter((box) => box.scrollWidth > box.clientWidth + 1).map((box) => box.ariaLabel),
  );
  found.cut_heads = await small.evaluate(() =>
    [...document.querySelectorAll('.round header')].filter((e) => e.scrollHeight > e.clientHeight + 1).map((e) => e.textContent),
  );
  found.overflow[390] = await small.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  if (prefix) await small.screenshot({ path: `${prefix}_390.png`, fullPage: true });
  const background = () => small.evaluate(() => getComputedStyle(document.body).backgroundColor);
  found.light = await background();
  await small.emulateMedia({ colorScheme: 'dark' });
  found.dark = await background();
  if (prefix) await small.screenshot({ path: `${prefix}_390_dark.png`, fullPage: true });

  const plain_context = await context.browser()?.newContext({ javaScriptEnabled: false });
  if (plain_context) {
    const plain = await visit(plain_context);
    found.plain = { rows: await plain.locator('tbody tr').count(), note: await plain.locator('noscript').count() };
  }
} finally {
  await context.close();
  rmSync(profile, { recursive: true, force: true });
}
process.stdout.write(JSON.stringify(found));
