// Pushes the finger as a reader would, and writes a line PASS or FAIL for each check into the page.
(async () => {
  const TURNS = document.getElementById('push-program') ? 1e6 : 100;
  const results = [];
  const check = (name, holds, found = '') => results.push(`${holds ? 'PASS' : 'FAIL'} ${name}${holds ? '' : `: ${found}`}`);
  const settle = (ms = 300) => new Promise((done) => setTimeout(done, ms));
  const one = (selector) => document.querySelector(selector), words = () => one('.push-says').textContent.replaceAll('\u00a0', ' ');
  const root = one('.push');
  // The browser's clock stands still for a message, but not the compiler of the program.
  const turn = () => new Promise((done) => { const { port1, port2 } = new MessageChannel(); port1.onmessage = () => { port1.close(); done(); }; port2.postMessage(0); });
  for (let turns = 0; turns < TURNS && !('ready' in root.dataset) && !root.dataset.failed; turns++) await turn();
  check('the picture is shown', !root.hidden && 'ready' in root.dataset, root.dataset.failed ?? 'hidden');
  const missing = one('.push-missing');
  if (!root.hidden) {
    check('no sentence says that the picture is missing', missing.hidden);
    const view = one('.push-drawing > svg'), shape = () => one('.push-bent').getAttribute('d');
    const [place, direction, force] = root.querySelectorAll('input[type=range]'), [knows, estimator, noise] = root.querySelectorAll('select');
    const slide = (range, value) => { range.value = value; range.dispatchEvent(new Event('input', { bubbles: true })); };
    const choose = (select, value) => { select.value = value; select.dispatchEvent(new Event('change', { bubbles: true })); };
    const numbers = () => {
      const [, force_n, low, high, truth] = words().match(/Sensed ([-\d.]+) N \(95 %: ([-\d.]+) N to ([-\d.]+) N\).*; true ([-\d.]+) N/) ?? [];
      return [force_n, low, high, truth].map(Number);
    };
    const sensible = () => { const [found, low, high, truth] = numbers(); return low <= found && found <= high && Math.abs(found - truth) < 0.2 * truth + 0.1; };
    await settle(1500);
    const [, least, most, truth] = numbers();
    check('a force of unknown contact is sensed at first', knows.value === 'sought' && least <= truth && truth <= most, words());
    check('the cell of the map is named', /(Trusted|Not trusted) here \(nearest cell of the map: /.test(words()), words());

    choose(knows, 'known'); await settle();
    check('a force of known contact is sensed', sensible(), words());
    let before = shape();
    slide(force, 2.5); await settle();
    check('more force bends it further, and is sensed', shape() !== before && numbers()[3] === 2.5 && sensible(), words());
    before = shape();
    slide(direction, -30); await settle();
    check('another direction bends it otherwise', shape() !== before && sensible(), words());
    slide(direction, 0); slide(force, 1); await settle();

    // A press on the plate and a drag across it.
    const box = view.getBoundingClientRect(), middle = [box.left + 0.4 * box.width, box.top + 0.25 * box.height];
    const pointer = (type, [clientX, clientY]) => view.dispatchEvent(new PointerEvent(type, { clientX, clientY, pointerId: 1, bubbles: true, cancelable: true }));
    view.setPointerCapture = () => {};
    const was = place.value;
    pointer('pointerdown', middle); await settle();
    check('a press moves the contact and keeps the force', place.value !== was && numbers()[3] === 1, `${place.value} ${words()}`);
    const pushed = [];
    for (const length of [30, 60, 90]) { pointer('pointermove', [middle[0], middle[1] + length]); await settle(); pushed.push(Number(force.value)); }
    pointer('pointerup', middle);
    check('a longer drag pushes harder', pushed[0] < pushed[1] && pushed[1] < pushed[2], pushed);
    pointer('pointermove', [middle[0], middle[1] + 10]); await settle();
    check('after it the pointer pushes no more', Number(force.value) === pushed[2], force.value);

    slide(direction, 0); slide(place, 80); slide(force, 2); await settle();
    const known = words();
    choose(knows, 'off'); await settle();
    check('a wrong contact gives another force, with its own map', words() !== known && /nearest cell of the map/.test(words()), words());
    choose(knows, 'sought'); await settle(1500);
    check('a sought contact is found and named', sensible() && /at [\d.]+ mm, -?[\d.]+ deg/.test(words()), words());
    choose(knows, 'other'); await settle();
    check('softer ends are warned of or wrong', /Warning|Not trusted/.test(words()) || !sensible(), words());
    choose(knows, 'known'); choose(estimator, 'least-squares'); await settle();
    check('another estimator answers', /Sensed|Refused/.test(words()) && /No map/.test(words()), words());
    choose(estimator, 'nonlinear'); choose(noise, '0.2'); await settle();
    const [, low, high] = numbers();
    choose(noise, '0.01'); await settle();
    check('less noise gives a narrower interval', numbers()[2] - numbers()[1] < high - low, `${low} ${high} ${words()}`);
    const image = words();
    root.querySelector('button').click(); await settle();
    check('another image has other noise', words() !== image || numbers()[2] - numbers()[1] < 0.02, words());
    check('every control has a name', [...root.querySelectorAll('input, select')].every((each) => each.closest('label')?.querySelector('span').textContent.trim()));
    check('no number is missing', !/NaN|undefined|null|Infinity/.test(words() + shape()), words());
    check('nothing is wider than the window', document.documentElement.scrollWidth <= innerWidth, document.documentElement.scrollWidth);
    results.push('DONE pushed');
  } else {
    check(`a sentence says why: ${missing.textContent}`, !missing.hidden && missing.textContent.includes('cannot be pushed on this page'));
    results.push('DONE hidden');
  }
  check('nothing went wrong', window.troubles.length === 0, window.troubles.join(' | '));
  const told = document.createElement('pre');
  told.textContent = `\n${results.join('\n')}\n`;
  document.body.append(told);
})();
