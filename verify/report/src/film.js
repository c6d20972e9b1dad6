// Lets the reader stop each animated drawing and choose its step. Without this script CSS plays the drawing.
(() => {
  'use strict';

  const make = (tag, attributes) => Object.assign(document.createElement(tag), attributes);

  function control(drawing) {
    const shots = [...drawing.querySelectorAll('[data-shot-s]')], last = shots.length - 1;
    const button = make('button', { type: 'button' });
    const slider = make('input', { type: 'range', min: 0, max: last, step: 1, ariaLabel: 'Step of the drawing' });
    const bar = make('div', { className: 'film' });
    bar.append(button, slider);
    drawing.after(bar);

    let timer = 0;
    const show = (step) => {
      slider.value = step;
      slider.ariaValueText = `${step + 1} of ${shots.length}`;
      shots.forEach((shot, i) => { shot.style.animation = 'none'; shot.style.visibility = i === step ? 'visible' : 'hidden'; });
    };
    const stop = () => { clearInterval(timer); timer = 0; button.textContent = 'Play'; };
    const play = () => {
      const next = () => show((Number(slider.value) + 1) % shots.length);
      timer = setInterval(next, 1000 * Number(shots[0].dataset.shotS));
      button.textContent = 'Pause';
    };
    slider.addEventListener('input', () => { stop(); show(Number(slider.value)); });
    button.addEventListener('click', () => (timer ? stop() : play()));
    // The still shot is shown first, so that a reader who prefers no motion sees it, too.
    show(shots.findIndex((shot) => shot.classList.contains('still')));
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) stop(); else play();
  }

  document.querySelectorAll('.drawing:has([data-shot-s])').forEach(control);
})();
