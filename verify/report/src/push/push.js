// The finger that one can push, as the object `finray`. push.wasm, in #push-program, computes its equilibrium and the sensed force; #push-data has the scene and the
// report's map of trusted cells. Without either, or where WebAssembly does not run, a sentence says so in place of the picture.
const finray = (() => {
  'use strict';

  const SIDE_DEG = 80; // largest direction that can be chosen, to either side of the normal
  const ARROW_MM = 45; // length of the largest force, as drawn
  const DRAG_MM = 2; // a shorter drag moves the contact and leaves the force as it was
  const STEPS = 450; // of the force, up to the largest
  const FRAME_MS = 12, PAUSE_MS = 80; // a slower answer waits for a pause of the pointer
  const NOISES_MM = [0.01, 0.02, 0.067, 0.2];

  const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

  // ---- the program ----

  /** The program from its text in base64: a function from a question to its answer. */
  async function program(base64) {
    const packed = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    const { instance } = await WebAssembly.instantiate(await new Response(unpacked).arrayBuffer(), {});
    const { memory, question, answer, text } = instance.exports;
    return (asked) => {
      const bytes = new TextEncoder().encode(JSON.stringify(asked));
      const [place, length] = [question(bytes.length), bytes.length];
      new Uint8Array(memory.buffer, place, length).set(bytes); // the buffer is taken after each call, which may enlarge the memory
      const said = answer();
      return JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, text(), said)));
    };
  }

  // ---- geometry: mm, y upwards ----

  const add = ([x, y], [dx, dy], times = 1) => [x + times * dx, y + times * dy];
  const dot = ([ax, ay], [bx, by]) => ax * bx + ay * by;
  const path = (points) => `M${points.map(([x, y]) => `${x.toFixed(2)},${(-y).toFixed(2)}`).join('L')}`;

  /** The front plate: position of a point along it, direction of a force, and back. */
  function plate({ front: [base, tip], front_mm, inward }) {
    const along = add(tip, base, -1).map((it) => it / front_mm);
    return {
      at: (s_mm) => add(base, along, s_mm),
      nearest: (point) => clamp(dot(add(point, base, -1), along), 0.02 * front_mm, front_mm),
      direction: (angle_deg) => {
        const angle = (angle_deg * Math.PI) / 180;
        return add(inward.map((it) => it * Math.cos(angle)), along, Math.sin(angle));
      },
      angleOf: (force) => (Math.atan2(dot(force, along), dot(force, inward)) * 180) / Math.PI,
    };
  }

  /** View of the finger at rest, with room for the arrow above and the bent finger below. */
  function viewBox(lines) {
    const points = lines.flat(), xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    return [left - 8, -high - ARROW_MM * 0.5, right - left + 22, high - low + ARROW_MM * 1.1];
  }

  function arrow(head, force, scale, kind) {
    const size = Math.hypot(...force);
    if (size * scale < 0.5) return [];
    const unit = force.map((it) => it / size), across = [-unit[1], unit[0]], length = size * scale, tip = Math.min(4, length);
    const back = add(head, unit, -tip);
    return [svg('path', { d: path([add(head, unit, -length), back]), class: kind }),
      svg('path', { d: `${path([head, add(back, across, 1.7), add(back, across, -1.7)])}Z`, class: `${kind} push-head` })];
  }

  // ---- verdict of the map ----

  const CLASSES = [[0.02, '#1f8a57'], [0.05, '#6cbf8b'], [0.1, '#c4e6ca'], [0.25, '#f2b134'], [Infinity, '#b0352b']];

  /** Colour of an error, as in the maps of the report; without an error, the page's colour of rules. */
  const colourOf = (error) => (error === null ? 'var(--rule)' : CLASSES.find(([limit]) => error <= limit)[1]);

  /** The front plate at rest, coloured by the map for the nearest direction: one line for each cell. */
  function band(map, angle_deg, front, front_mm) {
    if (!map) return [];
    const direction = nearest(map.angle_deg, angle_deg);
    const edges = [0, ...map.s_mm.slice(1).map((s_mm, i) => (s_mm + map.s_mm[i]) / 2), front_mm];
    return map.s_mm.map((_, place) => {
      const error = map.worst_error[place * map.angle_deg.length + direction];
      return svg('path', { d: path([front.at(edges[place]), front.at(edges[place + 1])]), class: 'push-band', stroke: colourOf(error) });
    });
  }

  /** Verdict of the report's map on a contact: words, and whether the cell of the contact is trusted. */
  function cellOf(map, s_mm, angle_deg) {
    if (!map) return ['No map for these choices.', null];
    const half = map.angle_deg.length > 1 ? (map.angle_deg[1] - map.angle_deg[0]) / 2 : 90;
    if (angle_deg < map.angle_deg[0] - half || angle_deg > map.angle_deg.at(-1) + half) return ['The map has no such direction: friction does not allow it.', null];
    const place = nearest(map.s_mm, s_mm), direction = nearest(map.angle_deg, angle_deg);
    const n = place * map.angle_deg.length + direction, error = map.worst_error[n];
    const where = `nearest cell of the map: ${number(map.s_mm[place])}${NBSP}mm, ${number(map.angle_deg[direction])}${NBSP}deg`;
    if (error === null) return [`Not trusted here (${where}): ${map.state[n]}.`, false];
    return [`${map.is_trusted[n] ? 'Trusted' : 'Not trusted'} here (${where}): mean error ${number(100 * error, 2)}${NBSP}% at the worst force.`, map.is_trusted[n]];
  }

  // ---- the page ----

  function choice(host, label, options, changed) {
    const select = html('select');
    select.append(...options.map(([value, words]) => html('option', { value }, words)));
    select.addEventListener('change', () => changed(select.value));
    host.append(html('label', {}, html('span', {}, label), select));
    return select;
  }

  function slider(host, label, [min, max, step], unit, changed) {
    const range = html('input', { type: 'range', min, max, step }), told = html('output');
    range.addEventListener('input', () => changed(Number(range.value)));
    host.append(html('label', {}, html('span', {}, label, ' ', told), range));
    return (value) => {
      range.value = value;
      told.textContent = `${number(value)}${NBSP}${unit}`;
      range.setAttribute('aria-valuetext', told.textContent);
    };
  }

  /** Shows a finger that the program has accepted. `before` is the state of the finger that was shown until now. Returns the state. */
  function start(root, data, ask, drawing, before = {}) {
    const decimals = Math.max(0, 2 - Math.floor(Math.log10(data.most_n)));
    const newton = (x) => (x === null ? 'infinite' : `${x.toFixed(decimals)}${NBSP}N`);
    const front = plate(drawing), scale = ARROW_MM / data.most_n;
    const state = { s_mm: 0.55 * drawing.front_mm, angle_deg: 0, force_n: data.first_n, knows: 'sought', estimator: 'nonlinear',
      noise_mm: data.noise_mm, image: 1, ...before };
    state.s_mm = Math.min(state.s_mm, drawing.front_mm);
    state.force_n = Math.min(state.force_n, data.most_n);
    const [picture, says, controls] = ['drawing', 'says', 'controls'].map((part) => document.querySelector(`.push-${part}`));
    controls.replaceChildren();
    const view = svg('svg', { viewBox: viewBox(drawing.lines).join(' '), role: 'img', 'aria-label': 'The finger. Press its upper plate and drag.' });
    const rest = svg('path', { d: drawing.lines.map(path).join(''), class: 'push-rest' });
    const bent = svg('path', { class: 'push-bent' }), moving = svg('g'), bands = svg('g');
    const label = (s_mm, words) => svg('text', { x: front.at(s_mm)[0], y: -front.at(s_mm)[1] - 5, 'text-anchor': 'middle' }, words);
    view.append(bands, rest, bent, moving, label(0, 'base'), label(drawing.front_mm, 'tip'));
    picture.replaceChildren(view);

    /** A program that stops is not asked again. */
    const draw = (unasked = false) => {
      if (root.dataset.failed) return;
      try {
        drawn(unasked);
      } catch (error) {
        show(root, error);
      }
    };
    // Each change is drawn once in the next frame. If the sensor takes longer than a frame, it is asked when the changes pause.
    let waits = false, slow = false, pause = 0;
    const change = (changes) => {
      Object.assign(state, changes);
      if ('knows' in changes || 'estimator' in changes) slow = false;
      if (waits) return;
      waits = true;
      requestAnimationFrame(() => {
        waits = false;
        clearTimeout(pause);
        if (slow) pause = setTimeout(draw, PAUSE_MS);
        draw(slow);
      });
    };
    const [place, direction, force] = [
      slider(controls, 'Position', [0.02 * drawing.front_mm, drawing.front_mm, 0.5], 'mm', (s_mm) => change({ s_mm })),
      slider(controls, 'Direction', [-SIDE_DEG, SIDE_DEG, 1], 'deg', (angle_deg) => change({ angle_deg })),
      slider(controls, 'Force', [0, data.most_n, data.most_n / STEPS], 'N', (force_n) => change({ force_n }))];
    const known = [['sought', 'not at all: position and direction sought'], ['known', 'exactly']];
    if (data.off) known.splice(2, 0, ['off', `assumed ${Math.abs(data.off.by_mm)} mm and ${Math.abs(data.off.by_deg)} deg off`]);
    if (data.other) known.push(['other', 'exactly, but base and tip softer than modelled']);
    choice(controls, 'Contact known', known, (knows) => change({ knows })).value = state.knows;
    choice(controls, 'Estimator', drawing.estimators, (estimator) => change({ estimator })).value = state.estimator;
    const noises = [...new Set([...NOISES_MM, data.noise_mm])].filter((it) => it > 0).sort((a, b) => a - b);
    choice(controls, 'Camera noise', noises.map((it) => [it, `${it} mm`]), (noise) => change({ noise_mm: Number(noise) })).value = state.noise_mm;
    const next = html('button', { type: 'button' }, 'Another image');
    next.addEventListener('click', () => change({ image: state.image + 1 }));
    controls.append(next);

    function question(unasked) {
      const contact = unasked ? 'unasked' : { known: 'known', other: 'known', sought: 'sought', off: { off: data.off } }[state.knows];
      const { s_mm, angle_deg, force_n, estimator, noise_mm, image } = state;
      return { s_mm, angle_deg, force_n, is_other: state.knows === 'other', contact, estimator, noise_mm, image };
    }

    // The maps are those of the nonlinear estimator under the report's noise.
    const mapped = () => (state.estimator === 'nonlinear' && state.noise_mm === data.noise_mm ? data.maps[state.knows] : undefined);

    function drawn(unasked) {
      place(state.s_mm);
      direction(state.angle_deg);
      force(state.force_n);
      const began = performance.now(), { bent: it, not_carried: reason, error } = ask({ push: question(unasked) }), towards = front.direction(state.angle_deg);
      const truth = towards.map((part) => part * state.force_n), [words, trusted] = cellOf(mapped(), state.s_mm, state.angle_deg);
      if (!unasked) slow = performance.now() - began > FRAME_MS;
      root.dataset.state = !it ? 'not-carried' : it.sensed === 'unasked' ? 'unasked' : Object.keys(it.sensed)[0];
      bands.replaceChildren(...band(mapped(), state.angle_deg, front, drawing.front_mm));
      // A warned answer is not trusted, whatever the mean of the cell.
      const warned = trusted && it?.sensed.force?.warnings.length > 0, light = trusted === null ? '' : warned ? 'is-warned' : trusted ? 'is-trusted' : 'is-not-trusted';
      const cell = Object.keys(data.maps).length === 0 ? '' : html('p', { class: `push-cell ${light}` }, words, warned ? ' This answer has a warning.' : '');
      if (!it) {
        bent.setAttribute('d', rest.getAttribute('d'));
        moving.replaceChildren(...arrow(front.at(state.s_mm), truth, scale, 'push-true'));
        says.replaceChildren(html('p', { class: 'push-answer' }, `Not carried: ${reason ?? error}`), cell);
        return;
      }
      const { force: sensed, refused } = it.sensed;
      bent.setAttribute('d', it.lines.map(path).join(''));
      const dots = drawing.markers.map((marker, i) => add(marker, it.seen[i]));
      moving.replaceChildren(...dots.map(([x, y]) => svg('circle', { cx: x, cy: -y, r: 1.1, class: 'push-marker' })),
        ...arrow(it.at, truth, scale, 'push-true'),
        ...(sensed ? arrow(sensed.at ?? it.at, front.direction(sensed.angle_deg).map((part) => part * sensed.force_n), scale, 'push-sensed') : []));
      const refusal = () => html('p', { class: 'push-answer', title: refused }, `Refused: ${refused.split(';')[0]}.`);
      if (it.sensed !== 'unasked') says.replaceChildren(...(sensed ? answered(sensed) : [refusal()]), cell);
    }

    function answered({ force_n, interval_n: [low, high], s_mm, angle_deg, warnings }) {
      const found = state.knows === 'sought' ? ` at ${number(s_mm)}${NBSP}mm, ${number(angle_deg, 2)}${NBSP}deg` : '';
      const words = [html('span', { class: 'push-sensed-word' }, `Sensed ${newton(force_n)}`), ` (95${NBSP}%: ${newton(low)} to ${newton(high)})${found}; `,
        html('span', { class: 'push-true-word' }, `true ${newton(state.force_n)}`), '.'];
      return [html('p', { class: 'push-answer' }, ...words), gauge(force_n, low, high), ...warnings.map((each) => html('p', { class: 'push-warning', title: each }, `Warning: ${each.split(/[:;]/)[0]}.`))];
    }

    /** The sensed force with its interval, and the true force, on one scale. */
    function gauge(sensed, low, high) {
      const x = (force_n) => 2 + 96 * clamp(force_n / (1.2 * data.most_n), 0, 1), hold = low !== null && low <= state.force_n && state.force_n <= high;
      return svg('svg', { viewBox: '0 0 100 10', class: 'push-gauge', 'aria-hidden': 'true' },
        svg('path', { d: 'M2,5H98', class: 'push-scale' }), svg('text', { x: 2, y: 9 }, '0'), svg('text', { x: 98, y: 9, 'text-anchor': 'end' }, `${number(1.2 * data.most_n)} N`),
        svg('rect', { x: x(low ?? 0), y: 3.2, width: Math.max(0.4, x(high ?? Infinity) - x(low ?? 0)), height: 3.6, class: hold ? 'push-holds' : 'push-misses' }),
        svg('path', { d: `M${x(sensed)},2.2V8`, class: 'push-sensed' }), svg('path', { d: `M${x(state.force_n)},4.2l1,-1.8h-2Z`, class: 'push-true push-head' }));
    }

    // A press on the plate moves the contact there; a drag pushes in its direction, the further the stronger.
    let from = null;
    const pointed = (event) => {
      const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(view.getScreenCTM().inverse());
      return [x, -y];
    };
    view.addEventListener('pointerdown', (event) => {
      from = pointed(event);
      view.setPointerCapture(event.pointerId);
      change({ s_mm: front.nearest(from) });
      event.preventDefault();
    });
    view.addEventListener('pointermove', (event) => {
      if (!from) return;
      const dragged = add(pointed(event), from, -1), length = Math.hypot(...dragged);
      if (length < DRAG_MM) return;
      change({ force_n: Math.min(data.most_n, length / scale), angle_deg: clamp(Math.round(front.angleOf(dragged)), -SIDE_DEG, SIDE_DEG) });
    });
    for (const end of ['pointerup', 'pointercancel']) view.addEventListener(end, () => { from = null; });
    draw();
    root.dataset.ready = '';
    return state;
  }

  /** Shows the picture, or in its place why there is none. */
  function show(root, error) {
    const missing = document.querySelector('.push-missing');
    [root, document.querySelector('.push-says')].forEach((each) => { each.hidden = Boolean(error); });
    missing.hidden = !error;
    if (!error) return;
    root.dataset.failed = String(error);
    missing.textContent = `The finger cannot be pushed on this page (${error.message ?? error}). Maps, tables and the other pages do not depend on it.`;
  }

  async function run() {
    const root = document.querySelector('.push'), text = document.getElementById('push-program')?.textContent;
    if (!root) return;
    try {
      if (!text) throw new Error('the page has no program');
      const ask = await program(text);
      const data = JSON.parse(document.getElementById('push-data').textContent), drawing = ask({ finger: { scene: data.scene, other: data.other } });
      if (drawing.error) throw new Error(drawing.error);
      show(root);
      if (document.querySelector('.push-scene')) edit(root, data, ask);
      else start(root, data, ask, drawing);
    } catch (error) {
      show(root, error);
    }
  }

  run();
  return { start, plate, add, path, CLASSES, colourOf };
})();
