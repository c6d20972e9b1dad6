// Functions that the scripts of the pages share.
const NBSP = '\u00a0'; // keeps number and unit on one line
const number = (x, digits = 3) => String(Number(x.toPrecision(digits)));
/** Creates an element without the attributes that are null. Data becomes attributes and text, never markup. */
const make = (space) => (tag, attributes = {}, ...children) => {
  const made = document.createElementNS(space, tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(name, value);
  made.append(...children);
  return made;
};
const html = make('http://www.w3.org/1999/xhtml'), svg = make('http://www.w3.org/2000/svg');
const nearest = (values, value) => {
  const away = values.map((each) => Math.abs(each - value));
  return away.indexOf(Math.min(...away));
};
