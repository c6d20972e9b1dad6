// Drives the animated drawing of a page, and writes what it finds into the page.
(async () => {
  const results = [];
  const check = (name, holds, found = '') => results.push(`${holds ? 'PASS' : 'FAIL'} ${name}${found === '' ? '' : `: ${found}`}`);
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const shots = [...document.querySelectorAll('[data-shot-s]')];
  const button = document.querySelector('.film button'), slider = document.querySelector('.film input');
  const shown = () => shots.map((shot, i) => (getComputedStyle(shot).visibility === 'visible' ? i : '')).join('');

  check('three shots have one control', shots.length === 3 && Boolean(button && slider));
  const seen = new Set();
  for (let i = 0; i < 12; i += 1) { seen.add(shown()); await wait(100); }
  check('it runs, one shot at a time', [...seen].sort().join() === '0,1,2', [...seen].join());
  button.click();
  const stopped = shown();
  await wait(900);
  check('a click stops it', shown() === stopped && button.textContent === 'Play', `${stopped} ${shown()}`);
  for (const step of [2, 0]) {
    slider.value = step;
    slider.dispatchEvent(new Event('input'));
    check(`the slider shows step ${step}`, shown() === String(step) && slider.ariaValueText === `${step + 1} of 3`, shown());
  }
  button.click();
  await wait(900);
  check('another click runs it again', button.textContent === 'Pause');
  check('nothing was logged or thrown', window.troubles.length === 0, window.troubles.join(' | '));
  const report = document.createElement('pre');
  report.textContent = `\n${results.join('\n')}\nDONE ${results.length} checks\n`;
  document.body.append(report);
})().catch((error) => document.body.append(`\nFAIL harness: ${error.stack}\nDONE\n`));
