// Fills the section "Ask the page" with the numbers in #explore-data. The page is complete without this section. If data are
// missing, the section or one of its panels stays hidden.
(() => {
  'use strict';

  const TRUSTED = 0.1; // a cell is trusted if its error is at most this share
  const TWO_SIDED_95 = 1.96;
  const WORST = 'worst';
  const TEXT_PX = 12, BUTTON_PX = 24; // as in explore.css
  const LARGEST_SCALE = 4.4; // px per mm; a drawing at a larger scale shows no more details
  const EPSILON = 1e-6; // positions and directions are equal within this difference, because the data are rounded

  // Kinds of cells: classes of errors in ascending order, then cells without an error. The first three kinds are trusted.
  const LIMITS = [[0.02, 'within-2'], [0.05, 'within-5'], [TRUSTED, 'within-10'], [0.25, 'within-25'], [Infinity, 'above-25']];
  const TRUSTED_KINDS = ['within-2', 'within-5', 'within-10'];
  const KINDS = {
    'within-2': 'within 2 %', 'within-5': '2 to 5 %', 'within-10': '5 to 10 %', 'within-25': '10 to 25 %', 'above-25': 'above 25 %',
    'refused': 'refused', 'no-equilibrium': 'no equilibrium', 'not-computed': 'not computed',
  };
  const PATTERNS = { 'refused': 'M-2,2L2,-2M0,8L8,0M6,10L10,6', 'no-equilibrium': 'M-2,6L2,10M0,0L8,8M6,-2L10,2', 'not-computed': 'M3,4h2' };

  // ---- words ----

  const some = (x) => typeof x === 'number' && Number.isFinite(x);
  const number = (x) => String(Number(x.toPrecision(3)));
  const mm = (x) => `${number(x)}${NBSP}mm`;
  const deg = (x) => `${number(x)}${NBSP}deg`;
  const newton = (x) => (!some(x) ? '-' : x > 0 && x < 0.001 ? '< 0.001' : x.toFixed(3));
  const list = (words) => (words.length < 2 ? words.join('') : `${words.slice(0, -1).join(', ')} and ${words.at(-1)}`);

  /** A share in percent with two significant digits. The end of an interval (signed) is written as 0.0 % if it is below 0.1 %. */
  function percent(x, signed = false) {
    if (!some(x)) return '-';
    const rounded = Number((100 * x).toPrecision(2)), size = Math.abs(rounded);
    if (size < 0.1) return (signed ? '0.0_%' : x === 0 ? '0_%' : '<_0.1_%').replaceAll('_', NBSP);
    return `${rounded.toFixed(size < 1 ? 2 : size < 10 ? 1 : 0)}${NBSP}%`;
  }

  /** A share of a count in percent. It is written as 100 % only if the share is the whole count. */
  function share(part, whole) {
    const words = percent(whole ? part / whole : 0);
    return part < whole && parseFloat(words) === 100 ? `>${NBSP}99${NBSP}%` : words;
  }

  // ---- the document ----

  /** Explanations of the names of fingers and estimators. */
  const about = {};

  const text = (x, y, words, anchor = 'middle') => svg('text', { x, y, 'text-anchor': anchor }, words);
  const line = ([x1, y1], [x2, y2], kind) => svg('line', { x1, y1, x2, y2, class: kind });
  const canvas = (width, height, ...children) => svg('svg', { width, height, 'aria-hidden': 'true' }, ...children);

  /** A table in which the first cell of each row is its heading. */
  function table(columns, rows) {
    const head = html('tr', {}, ...columns.map((name) => html('th', { scope: 'col' }, name)));
    const cells = ([first, ...rest]) => [html('th', { scope: 'row' }, first), ...rest.map((cell) => html('td', {}, cell))];
    const body = html('tbody', {}, ...rows.map((row) => html('tr', {}, ...cells(row))));
    return html('div', { class: 'explore-scroll' }, html('table', {}, html('thead', {}, head), body));
  }

  /** A labelled select. `offer` gets entries [value, words, whether it exists]; the select keeps its value if it exists, otherwise selects the first that exists. */
  function choice(host, label, changed) {
    const select = html('select');
    host.append(html('label', {}, html('span', {}, label), select));
    select.addEventListener('change', changed);
    select.offer = (options, wanted = select.value) => {
      const option = ([value, words, exists = true]) => html('option', { value, disabled: exists ? null : '', title: about[words] || null }, words);
      select.replaceChildren(...options.map(option));
      const open = options.filter(([, , exists = true]) => exists).map(([value]) => String(value));
      select.value = open.includes(String(wanted)) ? wanted : open[0];
    };
    return select;
  }

  /** Fills a cell by its kind. Colours are in the style sheet; patterns are defined in this document. */
  function paint(shape, kind) {
    shape.classList.add(kind);
    if (PATTERNS[kind]) shape.setAttribute('fill', `url(#explore-${kind})`);
    return shape;
  }

  function patterns() {
    const pattern = ([kind, d]) => svg('pattern', { id: `explore-${kind}`, width: 8, height: 8, patternUnits: 'userSpaceOnUse',
      class: 'explore-pattern' }, svg('rect', { width: 8, height: 8 }), svg('path', { d }));
    return canvas(0, 0, svg('defs', {}, ...Object.entries(PATTERNS).map(pattern)));
  }

  const patch = (kind) => [paint(svg('rect', { x: 1, y: 1, width: 26, height: 14, class: 'explore-patch' }), kind), KINDS[kind]];
  const stroke = (kind, words) => [line([1, 8], [27, 8], kind), words];
  const legend = (host, entries) =>
    host.replaceChildren(...entries.map(([swatch, words]) => html('li', {}, canvas(28, 16, swatch), words)));

  // ---- grids of cells ----

  /** Index of the nearest grid value, or -1 if the nearest value is further away than half a step. */
  function within(values, value) {
    const i = nearest(values, value), gaps = [values[i] - values[i - 1], values[i + 1] - values[i]].filter(some);
    return Math.abs(values[i] - value) <= Math.max(0, ...gaps) / 2 + EPSILON ? i : -1;
  }

  /** Start and end of each cell: halfway to its neighbours. The first and last cell extend to the limit if it is at most `rest` steps away. */
  function edges(values, low, high, alone, rest) {
    const between = values.slice(1).map((value, i) => (value + values[i]) / 2);
    const first = between.length ? between[0] - values[0] : alone, last = between.length ? values.at(-1) - between.at(-1) : alone;
    const start = values[0] - first, end = values.at(-1) + last;
    const all = [start - low <= 2 * rest * first + EPSILON ? low : start, ...between, high - end <= 2 * rest * last + EPSILON ? high : end];
    return values.map((_, i) => [all[i], all[i + 1]]);
  }

  /** Cells that are chosen with mouse, tap or arrow keys. After a click the chosen cell no longer follows the mouse; Escape ends this. */
  function cellGrid(host, name, label, picked) {
    const box = html('div', { class: 'explore-grid', role: 'grid', tabindex: 0, 'aria-label': label });
    const cursor = svg('g', { class: 'explore-cursor' }, svg('rect'), svg('rect'));
    let cells = new Map(), at = '', held = false;
    host.append(box);

    function select(column, row) {
      const cell = cells.get(`${column},${row}`);
      if (!cell) return false;
      cells.get(at)?.setAttribute('aria-selected', 'false');
      at = `${column},${row}`;
      cell.setAttribute('aria-selected', 'true');
      box.setAttribute('aria-activedescendant', cell.id);
      for (const outline of cursor.children)
        for (const side of ['x', 'y', 'width', 'height']) outline.setAttribute(side, cell.getAttribute(side));
      cursor.classList.toggle('held', held);
      picked(column, row);
      return true;
    }

    /** Moves to the next cell in a direction, across gaps; returns false at the edge. */
    function walk(columns, rows) {
      const [column, row] = at.split(',').map(Number);
      for (let n = 1; n < cells.size; n += 1) if (select(column + n * columns, row + n * rows)) return true;
      return false;
    }

    const keys = {
      ArrowLeft: () => walk(-1, 0), ArrowRight: () => walk(1, 0), ArrowUp: () => walk(0, 1), ArrowDown: () => walk(0, -1),
      Home: () => { while (walk(-1, 0)); }, End: () => { while (walk(1, 0)); }, Escape: () => { held = false; walk(0, 0); },
    };
    box.addEventListener('keydown', (event) => {
      if (!keys[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      keys[event.key]();
    });
    const pointed = (event) => event.target.dataset.cell ?? at;
    box.addEventListener('pointermove', (event) => {
      if (event.pointerType === 'mouse' && !held && pointed(event) !== at) select(...pointed(event).split(',').map(Number));
    });
    box.addEventListener('click', (event) => {
      if (!event.target.dataset.cell) return;
      held = !(held && pointed(event) === at);
      select(...pointed(event).split(',').map(Number));
    });

    /** Draws cells { column, row, x, y, width, height, kind, label } above the elements `under` and below the elements `over`. */
    return function show(width, height, all, under, over, selected) {
      const rows = new Map(all.map(({ row }) => [row, svg('g', { role: 'row' })]));
      cells = new Map(all.map(({ column, row, kind, label: words, ...place }) => {
        const cell = svg('rect', { ...place, id: `explore-${name}-${column}-${row}`, role: 'gridcell', 'aria-label': words,
          'aria-selected': 'false', 'data-cell': `${column},${row}`, 'data-kind': kind, class: 'explore-cell' });
        rows.get(row).append(paint(cell, kind));
        return [`${column},${row}`, cell];
      }));
      box.replaceChildren(svg('svg', { width, height, role: 'presentation' }, ...under, ...rows.values(), ...over, cursor));
      if (!select(...selected)) select(all[0].column, all[0].row);
    };
  }

  // ---- maps ----

  function sound(map) {
    const grids = [map.s_mm, map.angle_deg, map.force_n];
    if (!grids.every((grid) => grid?.length > 0 && grid.every(some))) return false;
    const size = grids.reduce((product, grid) => product * grid.length, 1);
    return ['error', 'bias', 'spread', 'samples', 'answered'].every((name) => map[name]?.length === size);
  }

  function reading(map, place, direction, force) {
    const n = (place * map.angle_deg.length + direction) * map.force_n.length + force, at = (name) => map[name][n] ?? null;
    return { force_n: map.force_n[force], error: at('error'), bias: at('bias'), spread: at('spread'), samples: at('samples'), answered: at('answered') };
  }

  function kindOf({ samples, error }) {
    if (samples === null) return 'not-computed';
    if (samples === 0) return 'no-equilibrium';
    return error === null ? 'refused' : LIMITS.find(([limit]) => error <= limit)[1];
  }

  /** The largest error of the given results of a cell, or the kind of cell if a result has no error. */
  function judge(readings) {
    const kinds = readings.map(kindOf), none = ['no-equilibrium', 'refused', 'not-computed'].find((kind) => kinds.includes(kind));
    const error = none ? null : Math.max(...readings.map((each) => each.error));
    return { error, kind: none ?? kindOf({ samples: 1, error }) };
  }

  const unique = (values) => [...new Set(values)];

  function mainCause(data, { truth, estimator, contact }, s, angle) {
    const map = data.causes?.find((each) => each.truth === truth && each.estimator === estimator && each.contact === contact);
    const place = map ? within(map.s_mm, s) : -1, direction = map ? within(map.angle_deg, angle) : -1;
    if (place < 0 || direction < 0) return null;
    const n = place * map.angle_deg.length + direction;
    return { practice: map.practice, cause: map.cause[n], part: map.share[n], where: `${number(map.force_n)} N (${mm(map.s_mm[place])}, ${deg(map.angle_deg[direction])})` };
  }

  function causeInWords(found) {
    if (!found) return 'The main cause was not computed here.';
    if (!found.cause) return `No main cause at ${found.where}.`;
    const without = some(found.part) ? `: without this cause the mean square error is ${share(Math.min(found.part, 1 - EPSILON), 1)} smaller` : '';
    return `Main cause at ${found.where}, ${found.practice}: ${found.cause}${without}.`;
  }

  function mapPanel(data, panel, shared) {
    const { front_mm: front, contacts, noise_mm: noise } = data.finger;
    const [truth, estimator, contact, force] = ['Finger', 'Estimator', 'Contact', 'Force'].map((label) => choice(panel.choices, label, update));
    const show = cellGrid(panel.drawing, 'map', 'Error by position and direction: arrow keys move the cell', pick);
    let map = null, at = { s: front / 2, angle: 0 };

    // Each select offers only the values that exist with the choices before it, so that no choice blocks another.
    function update() {
      let left = data.maps;
      for (const [select, name] of [[truth, 'truth'], [estimator, 'estimator'], [contact, 'contact']]) {
        const exists = (value) => left.some((each) => each[name] === value);
        select.offer(unique(data.maps.map((each) => each[name])).map((value) => [value, value, exists(value)]));
        left = left.filter((each) => each[name] === select.value);
      }
      [map] = left;
      const forces = unique(data.maps.flatMap((each) => each.force_n)).sort((a, b) => a - b);
      force.offer([[WORST, map.force_n.length > 1 ? `worst of ${list(map.force_n.map(number))} N` : 'worst'],
        ...forces.map((each) => [each, `${number(each)} N`, map.force_n.includes(each)])]);
      draw();
      shared.map = map;
      shared.changed();
    }

    const chosenForces = () => (force.value === WORST ? map.force_n : [Number(force.value)]);
    const readings = (place, direction) => chosenForces().map((each) => reading(map, place, direction, map.force_n.indexOf(each)));

    function pick(place, direction) {
      at = { s: map.s_mm[place], angle: map.angle_deg[direction] };
      const near = contacts[nearest(contacts.map((each) => each.s_mm), at.s)];
      const row = (each) => [`${number(each.force_n)} N`, each.error === null ? KINDS[kindOf(each)] : percent(each.error),
        percent(each.bias, true), percent(each.spread), each.samples ? `${each.answered}${NBSP}of${NBSP}${each.samples}` : '-'];
      const where = `${mm(at.s)} from the base, nearest node ${near.node} (at ${mm(near.s_mm)}); ${deg(at.angle)}.`;
      panel.text.replaceChildren(html('p', { class: 'explore-place' }, where),
        table(['Force', 'Error', 'Bias', 'Spread', 'Answered'], readings(place, direction).map(row)),
        html('p', {}, causeInWords(mainCause(data, map, at.s, at.angle))));
    }

    /** Kinds of the cells, by position, then direction. A cell counts by the plate and the directions that friction allows for which it stands. */
    function tell(kinds) {
      const counted = kinds.map((kind, n) => [kind, map.weight[n]]).filter(([, weight]) => weight > 0);
      const count = (...some_of) => counted.filter(([kind]) => some_of.includes(kind)).length;
      const weigh = (...some_of) => counted.reduce((sum, [kind, weight]) => sum + (some_of.includes(kind) ? weight : 0), 0);
      const whole = weigh(...Object.keys(KINDS)) - weigh('no-equilibrium', 'not-computed'), forces = list(chosenForces().map(number));
      panel.says.textContent = `At ${share(weigh(...TRUSTED_KINDS), whole)} of the positions and of the directions that friction allows, the mean error is within ` +
        `${percent(TRUSTED)} (${chosenForces().length > 1 ? 'worst of ' : ''}${forces} N); ` +
        `${count('refused')} of ${counted.length} cells refused, ${count('no-equilibrium')} without equilibrium.`;
      const samples = Math.max(0, ...map.samples.filter(some));
      panel.note.textContent = `Camera noise ${number(noise)} mm per coordinate; noise samples per cell and force: ${samples}. Error: mean of ` +
        '|sensed / true - 1|. No equilibrium: the finger cannot carry the force. A click keeps a cell chosen, Escape releases it. ';
      if (/^[\w.-]+\.csv$/.test(map.csv)) panel.note.append(html('a', { href: map.csv }, `data: ${map.csv}`));
    }

    function draw() {
      const width = widthOf(panel.drawing), left = 38, top = 26, wide = width - left - 12, high = Math.min(340, Math.max(230, width / 2));
      const x = (s) => left + (wide * s) / front, y = (angle) => top + (high * (90 - angle)) / 180;
      const columns = edges(map.s_mm, 0, front, 6, 0.5).map((ends) => ends.map(x)), rows = edges(map.angle_deg, -90, 90, 5, 0).map((ends) => ends.map(y));
      const judged = columns.map((_, i) => rows.map((__, j) => judge(readings(i, j))));
      const cell = ([x0, x1], i, [y0, y1], j) => ({ column: i, row: j, x: x0, y: y1, width: x1 - x0, height: y0 - y1, kind: judged[i][j].kind,
        label: `${mm(map.s_mm[i])}, ${deg(map.angle_deg[j])}: ${judged[i][j].error === null ? KINDS[judged[i][j].kind] : percent(judged[i][j].error)}` });
      const ground = paint(svg('rect', { x: left, y: top, width: wide, height: high }), 'not-computed');
      show(width, top + high + 56, columns.flatMap((ends, i) => rows.map((others, j) => cell(ends, i, others, j))), [ground],
        [border(judged, columns, rows), ...axes(x, y, top + high)], [nearest(map.s_mm, at.s), nearest(map.angle_deg, at.angle)]);
      tell(judged.flat().map((each) => each.kind));
    }

    function axes(x, y, base) {
      const steps = (from, to, step) => Array.from({ length: Math.floor((to - from) / step) + 1 }, (_, i) => from + i * step);
      const angles = steps(-80, 80, 40).flatMap((angle) => [text(x(0) - 6, y(angle) + 4, angle, 'end'), line([x(0) - 4, y(angle)], [x(0), y(angle)], 'explore-tick')]);
      const places = steps(0, front, 25).flatMap((s) => [text(x(s), base + 17, s), line([x(s), base], [x(s), base + 4], 'explore-tick')]);
      // Some node numbers are left out, so that they do not overlap.
      const apart = 1.8 * TEXT_PX, free = [];
      for (const each of contacts) if (x(each.s_mm) - (free.length ? x(free.at(-1).s_mm) : 0) >= apart) free.push(each);
      return [...angles, ...places, ...free.map((each) => text(x(each.s_mm), base + 34, each.node)), text(2, 14, 'direction, deg (positive: towards the tip)', 'start'),
        text(2, base + 17, 'mm', 'start'), text(2, base + 34, 'node', 'start'), text(x(0), base + 52, 'base', 'start'),
        text(x(front / 2), base + 52, 'along the front plate'), text(x(front), base + 52, 'tip', 'end')];
    }

    legend(panel.legend, [...Object.keys(KINDS).map(patch), stroke('explore-border', 'limit of 10 %')]);
    update();
    return draw;
  }

  /** The line between trusted and other cells, so that they differ not only by colour. */
  function border(judged, columns, rows) {
    const trusted = (i, j) => TRUSTED_KINDS.includes(judged[i][j].kind);
    const parts = (i, j) => [
      columns[i + 1] && trusted(i, j) !== trusted(i + 1, j) ? `M${columns[i][1]},${rows[j][0]}V${rows[j][1]}` : '',
      rows[j + 1] && trusted(i, j) !== trusted(i, j + 1) ? `M${columns[i][0]},${rows[j][1]}H${columns[i][1]}` : ''];
    return svg('path', { d: columns.flatMap((_, i) => rows.flatMap((__, j) => parts(i, j))).join(''), class: 'explore-border' });
  }

  // ---- drawings of the finger ----

  const widthOf = (host) => Math.max(200, Math.floor(host.clientWidth || 600));

  /** A drawing in mm that contains all points, with margins in px: top, right, bottom, left. */
  function stage(host, points, [above, right, below, left]) {
    const xs = points.map(([x]) => x), ys = points.map(([, y]) => y), first = Math.min(...xs), top = Math.max(...ys);
    const wide = Math.max(...xs) - first, scale = Math.min(LARGEST_SCALE, (widthOf(host) - left - right) / wide);
    const view = canvas(wide * scale + left + right, (top - Math.min(...ys)) * scale + above + below);
    return { view, at: ([x, y]) => [left + (x - first) * scale, above + (top - y) * scale] };
  }

  function drawFinger({ view, at }, { members }, nodes, kind) {
    view.append(svg('path', { d: members.map(([a, b]) => `M${at(nodes[a - 1])}L${at(nodes[b - 1])}`).join(''), class: kind }));
  }

  /** An arrow whose head is at a point in mm. Its length and its sideways shift are in px. */
  function drawArrow({ view, at }, head, [fx, fy], length, kind, aside = 0) {
    const size = Math.hypot(fx, fy), [ux, uy] = [fx / size, -fy / size], [hx, hy] = at(head), tip = Math.min(9, length);
    const point = (back, side) => [hx - ux * back - uy * (aside + side), hy - uy * back + ux * (aside + side)];
    view.append(line(point(length, 0), point(tip * 0.8, 0), kind),
      svg('path', { d: `M${point(0, 0)}L${point(tip, 4)}L${point(tip, -4)}Z`, class: `${kind} explore-head` }));
  }

  /** Unit vector of a direction, an angle in degrees from the front plate's inward normal, positive towards the tip. */
  function directionOf({ nodes, contacts }, angle) {
    const [a, b] = [nodes[contacts[0].node - 1], nodes[contacts.at(-1).node - 1]];
    const turned = Math.atan2(b[1] - a[1], b[0] - a[0]) - Math.PI / 2 + (angle * Math.PI) / 180;
    return [Math.cos(turned), Math.sin(turned)];
  }

  const shapesOf = (data) => (data.shapes ?? []).filter((shape) => shape.xy?.length === data.finger.nodes.length);
  /** Shapes of a true finger, or of the first one, as which the others bend. */
  const ofTruth = (shapes, truth) => shapes.filter((shape) => shape.truth === (shapes.some((each) => each.truth === truth) ? truth : shapes[0].truth));

  function nearestShape(shapes, node, angle) {
    const own = shapes.filter((shape) => shape.node === node);
    return own[nearest(own.map((shape) => shape.angle_deg), angle)];
  }

  function fingerPanel(data, panel, shared) {
    const { finger } = data, shapes = shapesOf(data), out = directionOf(finger, 180);
    const contacts = finger.contacts.filter(({ node }) => shapes.some((shape) => shape.node === node));
    if (contacts.length === 0) return null;
    const angles = unique(shapes.map((shape) => shape.angle_deg)).sort((a, b) => a - b);
    const angle = choice(panel.choices, 'Direction', draw), drawing = html('div', { class: 'explore-stage' });
    angle.offer(angles.map((each) => [each, deg(each)]), angles[nearest(angles, 0)]);
    panel.drawing.append(drawing);
    let chosen = contacts[Math.floor(contacts.length / 2)];

    function draw() {
      const of = (truth) => nearestShape(ofTruth(shapes, truth), chosen.node, Number(angle.value));
      const shape = of(shared.map?.truth) ?? of();
      // All shapes together determine the scale, so that it does not change with the choices.
      const drawn = stage(panel.drawing, [...finger.nodes, ...shapes.flatMap((each) => each.xy)], [70, 40, 8, 16]);
      drawFinger(drawn, finger, finger.nodes, 'explore-rest');
      drawFinger(drawn, finger, shape.xy, 'explore-bent');
      drawArrow(drawn, shape.xy[chosen.node - 1], directionOf(finger, shape.angle_deg), 44, 'explore-true');
      const places = contacts.map((contact) => drawn.at(finger.nodes[contact.node - 1]));
      const narrow = places.some(([x], i) => i > 0 && x - places[i - 1][0] < BUTTON_PX + 2);
      // On a narrow page every second button is drawn further outside.
      drawing.replaceChildren(drawn.view, ...contacts.map((contact, i) => button(contact, places[i], BUTTON_PX * (narrow && i % 2 ? 2.2 : 1.1))));
      tell(shape);
    }

    function button(contact, [x, y], away) {
      const pressed = String(contact === chosen), made = html('button', { type: 'button', 'aria-pressed': pressed, 'aria-label': `node ${contact.node}` }, contact.node);
      Object.assign(made.style, { left: `${x + away * out[0]}px`, top: `${y - away * out[1]}px` });
      made.addEventListener('click', () => {
        chosen = contact;
        draw();
        drawing.querySelector('[aria-pressed=true]').focus();
      });
      return made;
    }

    function tell(shape) {
      const [from, to] = [finger.nodes, shape.xy].map((nodes) => nodes[chosen.node - 1]), { truth, contact } = shared.map;
      panel.says.textContent = `${shape.truth}: ${number(shape.force_n)} N on node ${chosen.node} (${mm(chosen.s_mm)} from the base) at ` +
        `${deg(shape.angle_deg)} move it by ${mm(Math.hypot(to[0] - from[0], to[1] - from[1]))}.`;
      const same = data.maps.filter((map) => map.truth === truth && map.contact === contact);
      panel.text.replaceChildren(html('p', { class: 'explore-place' }, `Sensed at ${number(shape.force_n)} N on the ${truth}, contact ${contact}:`),
        table(['Estimator', 'Error', 'Bias +- 1.96 spread', 'Main cause'], same.map((map) => row(map, shape))));
    }

    function row(map, { angle_deg: direction, force_n }) {
      const i = within(map.s_mm, chosen.s_mm), j = within(map.angle_deg, direction), k = map.force_n.indexOf(force_n);
      const cell = i < 0 || j < 0 || k < 0 ? { samples: null, error: null } : reading(map, i, j, k);
      const reach = some(cell.spread) ? TWO_SIDED_95 * cell.spread : null;
      const interval = !some(cell.bias) ? '-' : reach === null ? `${percent(cell.bias, true)}, one sample`
        : `${percent(cell.bias - reach, true).slice(0, -2)}${NBSP}to${NBSP}${percent(cell.bias + reach, true)}`;
      return [map.estimator, cell.error === null ? KINDS[kindOf(cell)] : percent(cell.error), interval,
        mainCause(data, map, chosen.s_mm, direction)?.cause ?? '-'];
    }

    legend(panel.legend, [stroke('explore-bent', 'bent'), stroke('explore-rest', 'at rest'), stroke('explore-true', 'force')]);
    panel.note.textContent = 'Base left, tip right. Choose a node of the front plate by its number. Finger and contact are those chosen for the map.';
    shared.changed = draw;
    draw();
    return draw;
  }

  // ---- two contacts ----

  function pairsPanel(data, panel) {
    const pairs = data.pairs ?? [], shapes = ofTruth(shapesOf(data)), numbers = unique(pairs.flatMap((pair) => pair.nodes)).sort((a, b) => a - b);
    if (pairs.length === 0) return null;
    const estimators = unique(pairs.flatMap((pair) => Object.keys(pair).filter((name) => name !== 'nodes')));
    const estimator = choice(panel.choices, 'Shades: estimator', draw), part = choice(panel.choices, 'Shades: error of', draw);
    estimator.offer(estimators.map((name) => [name, name]));
    part.offer([[0, 'each force'], [1, 'their sum']]);
    const show = cellGrid(panel.drawing, 'pairs', 'Error by pair of nodes: arrow keys move the cell', pick);
    let at = [Math.floor(numbers.length / 3), Math.floor((2 * numbers.length) / 3)];

    function draw() {
      const side = Math.min(30, (widthOf(panel.drawing) - 36) / numbers.length), left = 34, top = 24, base = top + numbers.length * side;
      const cells = pairs.map((pair) => {
        const [column, row] = pair.nodes.map((node) => numbers.indexOf(node)).sort((a, b) => a - b);
        const error = pair[estimator.value]?.[Number(part.value)] ?? null, kind = kindOf({ samples: pair[estimator.value] ? 1 : null, error });
        return { column, row, x: left + column * side, y: base - (row + 1) * side, width: side, height: side, kind,
          label: `nodes ${list(pair.nodes)}: ${error === null ? KINDS[kind] : percent(error)}` };
      });
      const names = numbers.flatMap((node, i) => [
        ...(i > 0 ? [text(left - 6, base - (i + 0.5) * side + 4, node, 'end')] : []),
        ...(i < numbers.length - 1 ? [text(left + (i + 0.5) * side, base - side + 15, node)] : [])]);
      const titles = [text(2, 14, 'second node', 'start'), text(left + (numbers.length - 1) * side, base - side + 32, 'first node', 'end')];
      show(left + numbers.length * side + 2, base - side + 40, cells, [...names, ...titles], [], at);
    }

    function pick(column, row) {
      at = [column, row];
      const nodes = at.map((i) => numbers[i]), pair = pairs.find((each) => nodes.every((node) => each.nodes.includes(node)));
      const cell = (error) => (some(error) ? percent(error) : 'refused');
      const rows = estimators.filter((name) => pair[name]).map((name) => [name, cell(pair[name][0]), cell(pair[name][1])]);
      panel.says.textContent = `Two unknown forces, on nodes ${list(nodes)}.`;
      panel.text.replaceChildren(table(['Estimator', 'Error of each force', 'Of their sum'], rows), ...sketch(nodes));
    }

    function sketch(nodes) {
      const both = nodes.map((node) => nearestShape(shapes, node, 0));
      if (both.includes(undefined)) return [];
      const drawn = stage(panel.text, [data.finger.nodes, ...shapes.filter((each) => each.angle_deg === 0).map((each) => each.xy)].flat(), [34, 20, 8, 8]);
      drawFinger(drawn, data.finger, data.finger.nodes, 'explore-rest');
      for (const [shape, kind] of [[both[0], 'explore-first'], [both[1], 'explore-second']]) {
        drawFinger(drawn, data.finger, shape.xy, kind);
        drawArrow(drawn, shape.xy[shape.node - 1], directionOf(data.finger, shape.angle_deg), 30, kind);
      }
      return [drawn.view];
    }

    const lines = shapes.slice(0, 1).flatMap(({ force_n }) => [stroke('explore-first', `shape under ${number(force_n)} N on the first node alone`),
      stroke('explore-second', 'on the second alone')]);
    legend(panel.legend, [...Object.keys(KINDS).slice(0, 6).map(patch), ...lines]);
    panel.note.textContent = 'Error: mean of |sensed / true - 1|. The more similar two shapes are, the less accurately their forces are sensed.';
    draw();
    return draw;
  }

  // ---- objects ----

  const sizeOf = (force) => (force?.every(some) ? Math.hypot(...force) : null);

  function scenesPanel(data, panel) {
    const scenes = (data.scenes ?? []).filter((scene) => scene.steps?.length > 0), { finger } = data;
    if (scenes.length === 0) return null;
    const range = html('input', { type: 'range', min: 0, value: 100 }), told = html('output');
    const scene = choice(panel.choices, 'Object', () => { range.max = 100; range.value = 100; draw(); });
    scene.offer(scenes.map(({ name }, i) => [i, name]));
    panel.choices.append(html('label', { class: 'explore-range' }, html('span', {}, 'Travel'), range, told));
    range.addEventListener('input', draw);

    function draw() {
      const { name, steps } = scenes[Number(scene.value)];
      range.max = steps.length - 1;
      const step = steps[Number(range.value)], count = step.contacts.length;
      told.textContent = `${mm(step.travel_mm)}, step ${Number(range.value) + 1} of ${steps.length}`;
      range.setAttribute('aria-valuetext', told.textContent);
      panel.says.textContent = `${name}: ${count} ${count === 1 ? 'contact' : 'contacts'} after ${mm(step.travel_mm)}.`;
      const row = (contact, i) => [`${i + 1}: ${number(contact.x)}, ${number(contact.y)}`, newton(sizeOf(contact.true)),
        contact.sensed ? newton(sizeOf(contact.sensed)) : 'not identifiable', newton(contact.sigma_n)];
      panel.text.replaceChildren(table(['Contact at x, y (mm)', 'True, N', 'Sensed, N', 'Sigma, N'], step.contacts.map(row)));
      panel.note.textContent = step.xy ? 'Base left, tip right. Arrows and numbers are forces along the normal of each contact, drawn to one scale for all steps; true and sensed arrows are side by side.'
        : 'The shape of this step is not stored: the finger is drawn at rest.';
      picture(steps, step);
    }

    function picture(steps, step) {
      // All steps have the same scales of lengths and of forces.
      const drawn = stage(panel.drawing, [finger.nodes, ...steps.flatMap((each) => [each.xy ?? [], each.outline ?? []])].flat(), [40, 16, 20, 8]);
      const most = Math.max(...steps.flatMap((each) => each.contacts.flatMap((one) => [sizeOf(one.true), sizeOf(one.sensed)])));
      if (step.outline) drawn.view.append(svg('path', { d: `M${step.outline.map(drawn.at).join('L')}Z`, class: 'explore-outline' }));
      drawFinger(drawn, finger, step.xy ?? finger.nodes, step.xy ? 'explore-bent' : 'explore-rest');
      step.contacts.forEach((contact, i) => {
        const head = [contact.x, contact.y], [x, y] = drawn.at(head);
        for (const [force, kind, aside] of [[contact.true, 'explore-true', -4], [contact.sensed, 'explore-sensed', 4]])
          if (sizeOf(force)) drawArrow(drawn, head, force, Math.max(8, (64 * sizeOf(force)) / most), kind, aside);
        drawn.view.append(text(x, y + 18, i + 1));
      });
      panel.drawing.replaceChildren(drawn.view);
    }

    legend(panel.legend, [stroke('explore-true', 'true force'), stroke('explore-sensed', 'sensed force'),
      stroke('explore-bent', 'finger'), stroke('explore-outline', 'object')]);
    draw();
    return draw;
  }

  // ---- start ----

  function read() {
    const data = JSON.parse(document.getElementById('explore-data').textContent), { nodes, members, contacts, front_mm: front } = data.finger;
    data.maps = data.maps.filter(sound);
    return [data.maps, nodes, members, contacts].every((each) => each.length > 0) && front > 0 ? data : null;
  }

  /** Builds a panel and returns a function that draws it again. A panel that cannot be built stays hidden; the others still work. */
  function build(root, name, panel, data, shared) {
    const host = root.querySelector(`[data-panel=${name}]`), parts = ['choices', 'says', 'drawing', 'legend', 'note', 'text'];
    let draw = null;
    host.hidden = false; // a hidden panel has no width
    try {
      draw = panel(data, Object.fromEntries(parts.map((part) => [part, host.querySelector(`.explore-${part}`)])), shared);
    } catch { /* hidden below */ }
    host.hidden = !draw;
    return draw;
  }

  function start() {
    const root = document.querySelector('.explore'), data = read(), shared = { map: null, changed() {} };
    const all = [root, ...document.querySelectorAll('[data-explore-only]')], hide = (hidden) => all.forEach((each) => { each.hidden = hidden; });
    if (!data) return;
    Object.assign(about, data.about);
    hide(false);
    root.prepend(patterns());
    let width = root.clientWidth; // width before a scroll bar reduces it
    const panels = { map: mapPanel, finger: fingerPanel, pairs: pairsPanel, scenes: scenesPanel };
    const draws = Object.entries(panels).map(([name, panel]) => build(root, name, panel, data, shared)).filter(Boolean);
    if (!shared.map) return hide(true);
    const fit = () => {
      if (root.clientWidth === width || root.clientWidth === 0) return;
      width = root.clientWidth;
      draws.forEach((draw) => draw());
    };
    fit();
    new ResizeObserver(() => requestAnimationFrame(fit)).observe(root); // in a separate animation frame, because fitting changes the height
  }

  try { start(); } catch { /* No data, or none that can be read: the section stays hidden. */ }
})();
