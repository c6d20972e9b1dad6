// Drives the page as a reader would, and writes a line PASS or FAIL for each check into it.
(async () => {
  const results = [];
  const check = (name, holds, found = '') => results.push(`${holds ? 'PASS' : 'FAIL'} ${name}${holds ? '' : `: ${found}`}`);
  const json = document.getElementById('explore-data').textContent, data = JSON.parse(json);
  const scripts = [...document.querySelectorAll('script:not([type])')].map((script) => script.textContent);
  const styles = [...document.querySelectorAll('style')].map((style) => style.textContent).join('\n');
  const settle = () => new Promise((done) => setTimeout(done, 200));

  const panel = (name, root = document) => root.querySelector(`[data-panel=${name}]`);
  const choose = (select, value) => { select.value = value; select.dispatchEvent(new Event('change', { bubbles: true })); };
  const press = (grid, key) => grid.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
  const words = (name, part) => panel(name).querySelector(`.explore-${part}`).textContent.replaceAll('\u00a0', ' ');
  const drawn = (name) => panel(name).querySelector('.explore-drawing').innerHTML;

  // The section as it stands in the file, before the script ran: choices and drawings emptied, all hidden.
  const section = document.querySelector('section[data-explore-only]').cloneNode(true);
  for (const filled of section.querySelectorAll('.explore-choices,.explore-says,.explore-drawing,.explore-legend,.explore-note,.explore-text')) filled.replaceChildren();
  for (const shown of [section, ...section.querySelectorAll('.explore,.explore-panel')]) shown.hidden = true;
  section.querySelector('.explore > svg')?.remove();

  /** The section with other data, or at another width. */
  async function sectionWith(text, width = 900) {
    const frame = document.createElement('iframe');
    frame.style.cssText = `position:fixed;top:0;left:0;width:${width}px;height:900px;border:0`;
    document.body.append(frame);
    const inside = frame.contentDocument;
    inside.open();
    inside.write(`<!DOCTYPE html><html><head><meta name="viewport" content="width=device-width"><style>${styles}</style><script>${scripts[0]}<\/script></head>` +
      `<body><main>${section.outerHTML}</main><script type="application/json" id="explore-data">${text}<\/script><script>${scripts[1]}<\/script></body></html>`);
    inside.close();
    await settle();
    const troubles = frame.contentWindow.troubles;
    return { inside, troubles, close: () => frame.remove() };
  }

  // ---- the map: shares counted anew from the lists, for every choice ----
  const named = [...panel('map').querySelectorAll('option')].filter((option) => data.about[option.textContent]);
  check('names of fingers and estimators are explained', named.length > 1 && named.every((option) => option.title === data.about[option.textContent]), named.length);
  const ofData = { map: 'maps', finger: 'shapes', pairs: 'pairs', scenes: 'scenes' };
  const panels = Object.keys(ofData).filter((name) => data[ofData[name]].length > 0);
  const open = (root) => Object.keys(ofData).filter((name) => !panel(name, root).hidden).join();
  check('the section is shown, with a panel for whatever has data', !document.querySelector('.explore').hidden && open(document) === panels.join(), open(document));
  const [truth, estimator, contact, force] = panel('map').querySelectorAll('select');
  check('the worst force is what is shown first', force.value === 'worst', force.value);

  // Parts of a range that are nearest to each of some ascending values.
  const parts = (values, from, to) => {
    const clamp = (value) => Math.min(to, Math.max(from, value)), middle = (i) => (values[i - 1] + values[i]) / 2;
    const edge = (i) => (i === 0 ? from : i === values.length ? to : clamp(middle(i)));
    return values.map((_, i) => edge(i + 1) - edge(i));
  };
  const weightsOf = (map) => {
    const angles = map.angle_deg, stated = /^contact (known|misjudged)/.test(map.contact);
    const sectors = angles.length === 1 ? [1] : stated ? parts(angles, -45, 45) : parts(angles, angles[0], angles.at(-1));
    return parts(map.s_mm, 0, data.finger.front_mm).flatMap((length) => sectors.map((sector) => length * sector));
  };

  function countOf(map, criterion) {
    const found = { trusted: 0, refused: 0, none: 0, carried: 0, cells: 0, painted: 0 }, weights = weightsOf(map);
    const forces = criterion === 'worst' ? [...map.force_n.keys()] : [map.force_n.indexOf(Number(criterion))];
    for (let cell = 0; cell < map.s_mm.length * map.angle_deg.length; cell++) {
      const at = (name) => forces.map((k) => map[name][cell * map.force_n.length + k]);
      const weight = weights[cell], counts = weight > 0 ? 1 : 0, trusted = !at('error').includes(null) && at('error').every((error) => error <= 0.1);
      found.cells += counts;
      if (at('samples').includes(0)) { found.none += counts; continue; }
      found.carried += weight;
      if (at('error').includes(null)) found.refused += counts;
      if (trusted) { found.trusted += weight; found.painted++; }
    }
    return found;
  }

  const wrong = [], said = new Set(), kinds = new Set();
  let combinations = 0;
  for (const map of data.maps) {
    choose(truth, map.truth); choose(estimator, map.estimator); choose(contact, map.contact);
    for (const option of [...force.options].filter((each) => !each.disabled).map((each) => each.value)) {
      choose(force, option);
      combinations++;
      const expected = countOf(map, option), shown = words('map', 'says');
      const cells = [...panel('map').querySelectorAll('[role=gridcell]')].map((cell) => cell.dataset.kind);
      const painted = cells.filter((kind) => ['within-2', 'within-5', 'within-10'].includes(kind)).length;
      const [, share, refused, of, none] = shown.match(/At (.*?) % of the positions.*?; (\d+) of (\d+) cells refused, (\d+) without/) ?? [];
      const exact = expected.carried ? (100 * expected.trusted) / expected.carried : 0;
      const near = Math.abs(Number(String(share).replace(/[<>] ?/, '')) - exact) <= (exact < 10 ? 0.11 : 1);
      if (!near || Number(of) !== expected.cells || Number(refused) !== expected.refused || Number(none) !== expected.none || painted !== expected.painted)
        wrong.push(`${map.truth}, ${map.estimator}, ${map.contact}, ${option}: ${shown} ${JSON.stringify(expected)} painted ${painted}`);
      said.add(shown); kinds.add(cells.join());
    }
  }
  check(`shares of ${combinations} choices are those of their cells`, wrong.length === 0 && combinations > 20, wrong.slice(0, 2).join(' | '));
  check('choices change words and cells', said.size > combinations / 4 && kinds.size > combinations / 4, `${said.size} ${kinds.size}`);

  // ---- the map: keyboard ----
  const first = data.maps[0];
  choose(truth, first.truth); choose(estimator, first.estimator); choose(contact, first.contact); choose(force, 'worst');
  const grid = panel('map').querySelector('[role=grid]'), active = () => grid.querySelector('[aria-selected=true]');
  const where = () => active().dataset.cell.split(',').map(Number);
  press(grid, 'Home');
  const before = words('map', 'text'), start = where();
  press(grid, 'ArrowRight'); press(grid, 'ArrowUp');
  check('arrow keys move the cell', start[0] === 0 && where()[0] === 1 && where()[1] === start[1] + 1, `${start} ${where()}`);
  check('the cell in words follows', words('map', 'text') !== before);
  check('the cell is named to screen readers', grid.getAttribute('aria-activedescendant') === active().id && panel('map').querySelector('.explore-text').getAttribute('aria-live') === 'polite');
  const cell = (where()[0] * first.angle_deg.length + where()[1]) * first.force_n.length;
  const rows = first.force_n.every((newton, k) => words('map', 'text').includes(`${newton} N`) && words('map', 'text').includes(`${first.answered[cell + k]} of ${first.samples[cell + k]}`));
  check('each force has its row with its counts', rows, words('map', 'text'));
  press(grid, 'End'); check('End goes to the tip', where()[0] === first.s_mm.length - 1, where());

  // ---- the other panels ----
  const direction = panel('finger').querySelector('select'), buttons = () => panel('finger').querySelectorAll('button');
  const shapes = new Set();
  for (const value of ['0', '40']) for (const nth of [0, 5]) { choose(direction, value); buttons()[nth].click(); shapes.add(drawn('finger')); }
  check('nodes and directions change the shape', shapes.size === 4, shapes.size);
  // A finger bends as it is: with softer ends otherwise than the uniform one.
  const bends = (name) => { choose(truth, name); return drawn('finger'); };
  if (data.maps.some((map) => map.truth === 'softer ends')) {
    const uniform = bends(first.truth);
    check('another finger has another shape', bends('softer ends') !== uniform && words('finger', 'says').startsWith('softer ends'), words('finger', 'says'));
    choose(truth, first.truth);
  }
  check('the chosen node is pressed', panel('finger').querySelectorAll('[aria-pressed=true]').length === 1);
  if (panels.includes('pairs')) {
    const pairs = panel('pairs').querySelector('[role=grid]'), pair = words('pairs', 'text');
    press(pairs, 'ArrowUp'); press(pairs, 'ArrowRight');
    check('arrow keys change the pair, both shapes are drawn', words('pairs', 'text') !== pair && ['first', 'second'].every((kind) => panel('pairs').querySelector(`.explore-text .explore-${kind}`)));
  }
  const object = panel('scenes').querySelector('select'), travel = panel('scenes').querySelector('input'), steps = new Set();
  data.scenes.forEach((scene, at) => {
    choose(object, String(at));
    scene.steps.forEach((_, step) => { travel.value = step; travel.dispatchEvent(new Event('input')); steps.add(drawn('scenes') + words('scenes', 'text')); });
  });
  check('every step of every scene differs', steps.size === data.scenes.flatMap((scene) => scene.steps).length, steps.size);
  const shown = document.querySelector('.explore').textContent;
  check('no number has an exponent, and none is missing', !/\de[-+]?\d|NaN|undefined|Infinity|null/.test(shown), shown.match(/.{20}(\de[-+]?\d|NaN|undefined|Infinity|null).{10}/)?.[0]);
  check('nothing was logged or thrown', window.troubles.length === 0, window.troubles.join(' | '));

  // ---- a phone, and data that are not there ----
  for (const width of [320, 390]) {
    const { inside, troubles, close } = await sectionWith(json, width);
    const fits = inside.documentElement.scrollWidth <= width;
    check(`nothing is wider than ${width} px`, fits && troubles.length === 0, `${inside.documentElement.scrollWidth} ${troubles}`);
    close();
  }
  for (const [name, text] of [['broken JSON', json.slice(0, 5000)], ['an empty object', '{}']]) {
    const { inside, troubles, close } = await sectionWith(text);
    check(`hidden and silent: ${name}`, inside.querySelector('.explore').hidden && troubles.length === 0, troubles.join());
    close();
  }
  for (const missing of ['shapes', 'pairs', 'scenes', 'causes']) {
    const { inside, troubles, close } = await sectionWith(JSON.stringify({ ...data, [missing]: [] }));
    const expected = panels.filter((name) => ofData[name] !== missing).join();
    check(`without ${missing} the rest is shown`, open(inside) === expected && troubles.length === 0, `${open(inside)} ${troubles}`);
    close();
  }
  const odd = { ...data, maps: [{ ...first, truth: '<b>bold</b>', csv: 'javascript:alert(1)' }] };
  const { inside, troubles, close } = await sectionWith(JSON.stringify(odd).replaceAll('<', '\\u003c'));
  check('names in data stay words, a wrong link is left out', !inside.querySelector('.explore b, .explore-note a') && troubles.length === 0, troubles.join());
  close();

  const report = document.createElement('pre');
  report.textContent = `\n${results.join('\n')}\nDONE ${results.length} checks\n`;
  document.body.append(report);
})().catch((error) => document.body.append(`\nFAIL harness: ${error.stack}\nDONE\n`));
