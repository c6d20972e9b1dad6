// Before the script: what goes wrong is kept for the harness.
window.troubles = [];
window.addEventListener('error', (event) => window.troubles.push(event.message));
window.addEventListener('unhandledrejection', (event) => window.troubles.push(String(event.reason)));
for (const kind of ['error', 'warn']) console[kind] = (...words) => window.troubles.push(words.join(' '));
