// The number field beside a slider takes what a person writes (0.05, 5e-2, 5·10⁻², 50 m, 50 mm) and holds the value itself
// where its slider moves in decades. What is typed counts on Enter or when the field is left.
({fields}) => {
  const viser = window.observerLabViser, lab = window.observerLabFields ??= {};
  lab.fields = fields;
  if (lab.dress) { lab.dress(); return; }
  const POWERS = {f: -15, p: -12, n: -9, µ: -6, μ: -6, u: -6, m: -3, k: 3, M: 6, G: 9, T: 12}, RAISED = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  const plain = words => words.trim().replace(/[−–]/g, '-')
    .replace(/([⁺⁻]?)([⁰¹²³⁴⁵⁶⁷⁸⁹]+)/g, (_, sign, digits) => '^' + (sign === '⁻' ? '-' : '') + [...digits].map(d => RAISED.indexOf(d)).join(''));
  const BASE = /^(m|s|g|A|V|N|W|K|Hz|rad|Pa|J|C|F|H|T|Ω)(?:\^(-?\d+))?(?![A-Za-z])/;  // what a prefix stands before, and its power
  const times = symbol => Number(BASE.exec(symbol)?.[2] ?? 1);
  const power = (unit, meant) => {  // of ten by which a number in `unit` becomes one in `meant`; NaN where it cannot
    if (unit === '' || unit === meant) return 0;
    if (BASE.test(meant) && unit.endsWith(meant)) return (POWERS[unit.slice(0, -meant.length)] ?? NaN) * times(meant);
    const rest = meant.slice(1), own = BASE.test(rest) ? POWERS[meant[0]] : undefined;  // metres where millimetres are meant
    if (own === undefined || !unit.endsWith(rest)) return POWERS[unit] ?? NaN;
    return ((unit === rest ? 0 : POWERS[unit.slice(0, -rest.length)] ?? NaN) - own) * times(rest);
  };
  lab.read = (words, unit) => {
    const typed = plain(words);
    if (/^[-+]?[1-9]\d{0,2}(,\d{3})+/.test(typed)) return NaN;  // thousands to one reader, three decimals to another
    const said = typed.replace(',', '.'), tail = String.raw`\s*([^\d.].*)?$`;
    const power10 = RegExp(String.raw`^([-+]?)10\^([-+]?\d+)` + tail).exec(said);
    const number = RegExp(String.raw`^([-+]?(?:\d+\.?\d*|\.\d+))(?:e([-+]?\d+)|\s*[·×*x]\s*10\^([-+]?\d+))?` + tail, 'i').exec(said);
    if (!power10 && !number) return NaN;
    const [mantissa, tens, left] = power10 ? [`${power10[1]}1`, power10[2], power10[3]] : [number[1], number[2] ?? number[3] ?? 0, number[4]];
    const shift = power((left ?? '').trim(), plain(unit));
    return Number.isNaN(shift) ? NaN : Number(`${mantissa}e${Number(tens) + shift}`);
  };
  const raised = power => String(power).replace('-', '⁻').replace(/\d/g, digit => RAISED[digit]);
  lab.written = value => {
    const size = Math.abs(value), short = Number(value.toPrecision(size >= 1000 ? 6 : size >= 1 ? 4 : 3));  // what fits the field
    if (size === 0 || (size >= 1e-3 && size < 1e6)) return String(short).replace('-', '−');
    const [mantissa, tens] = value.toExponential(2).split('e');
    return `${String(Number(mantissa)).replace('-', '−')}·10${raised(Number(tens))}`.replace(/^1·/, '');
  };
  const place = id => {
    const slider = document.getElementById(id), row = slider?.parentElement;
    const theirs = row?.querySelector(`input${viser.parts.numberInput}:not(.ol-value)`);
    return theirs && {theirs, thumb: slider.querySelector('[role=slider]'), own: row.querySelector('input.ol-value')};
  };
  const give = (id, value) => {  // to the slider as if it had come from the server, then to it: a published page answers at once
    if (Number.isFinite(value)) viser.show([viser.changed(id, {value})]);  // what is no number gets one sentence
    viser.tell(id, value);
  };
  const shown = (id, thumb) => {
    const at = Number(thumb.getAttribute('aria-valuenow'));
    return lab.written(lab.fields[id].log ? Number((10 ** at).toPrecision(3)) : at);
  };
  const fit = (id, {own, thumb}) => {
    const words = shown(id, thumb);
    if (own.dataset.shown === words && own.dataset.typed !== 'over') return;
    if (own.dataset.typed === 'now') return;  // not over the hand
    own.dataset.shown = own.value = words;
    own.dataset.typed = '';
    thumb.setAttribute('aria-valuetext', words);
  };
  const commit = (id, own) => {
    const parts = place(id), {unit, log} = lab.fields[id] ?? {};
    if (own.dataset.typed !== 'now' || !parts || unit === undefined) return;
    own.dataset.typed = 'over';
    const value = lab.read(own.value, unit);
    give(id, log ? Math.log10(value) : value);
    setTimeout(() => { const now = place(id); if (now?.own) fit(id, now); }, 120);
  };
  const make = (id, {theirs, thumb}) => {
    const own = theirs.cloneNode();
    own.removeAttribute('id');
    own.classList.add('ol-value');
    own.setAttribute('aria-label', lab.fields[id].name);
    theirs.style.display = 'none';
    theirs.tabIndex = -1;
    theirs.after(own);
    own.addEventListener('input', () => { own.dataset.typed = 'now'; });
    own.addEventListener('blur', () => commit(id, own));
    own.addEventListener('keydown', event => {
      const by = {ArrowUp: 1, ArrowDown: -1}[event.key];
      if (event.key === 'Enter') commit(id, own);
      else if (event.key === 'Escape') { own.dataset.typed = 'over'; fit(id, {own, thumb: place(id).thumb}); }
      else if (by) { event.preventDefault(); give(id, Number(place(id).thumb.getAttribute('aria-valuenow')) + by * lab.fields[id].step); }
    });
    return {own, thumb};
  };
  lab.dress = () => {
    for (const id of Object.keys(lab.fields)) {
      const parts = place(id);
      if (parts) fit(id, parts.own ? parts : make(id, parts));
    }
  };
  new MutationObserver(() => lab.dress()).observe(document.body,
    {childList: true, subtree: true, attributes: true, attributeFilter: ['aria-valuenow']});
  lab.dress();
}
