// Runs before viser's page: shows our name until a lesson stands, and says so for as long as the server does not answer. After that
// each column is scrolled to where it was, and what was being typed stands there again.
({words, language, kept}) => {
  const root = document.documentElement, cover = document.createElement('div'), note = document.createElement('div');
  const viser = window.observerLabViser, line = window.observerLabLine, TYPED = 'textarea,.ol-number input', STEP = 60, STILL = 1500, LONGEST = 20000;  // ms
  const known = code => words[code] ?? words[language];
  const remembered = () => { try { return sessionStorage.getItem(kept); } catch (error) { return null; } };
  root.lang = known(remembered()) === words[remembered()] ? remembered() : language;
  cover.className = 'ol-cover';
  note.className = 'ol-lost';
  note.hidden = true;
  note.setAttribute('role', 'alert');
  let reason = 'lost', left = null;
  const speak = () => {
    const said = known(root.lang), name = document.createElement('b'), loading = document.createElement('span');
    name.textContent = said.name;
    loading.textContent = said.loading;
    cover.replaceChildren(name, loading);
    note.textContent = said[reason].replaceAll('{name}', location.hostname);
    note.classList.toggle('ol-rests', reason === 'rests');
  };
  speak();
  root.append(cover, note);
  const all = selector => [...document.querySelectorAll(selector)];
  const leave = () => ({scrolled: all(viser.parts.view).map(view => view.scrollTop), typed: all(TYPED).map(field => field.value),
    opened: all('details').map(part => part.open)});
  const goBack = ({scrolled, typed, opened}) => {
    const hands = ['wheel', 'pointerdown', 'keydown', 'touchstart'], end = performance.now() + LONGEST;
    let moved = false, still = performance.now();
    const mine = event => { moved ||= event.isTrusted; };  // a hand has the last word
    hands.forEach(kind => addEventListener(kind, mine, {capture: true, passive: true}));
    const put = (parts, values, set) => { if (parts.length === values.length) parts.forEach((part, k) => set(part, values[k])); };
    const settle = () => {
      if (moved || performance.now() > end || performance.now() - still > STILL) {
        hands.forEach(kind => removeEventListener(kind, mine, {capture: true}));
        return;
      }
      put(all('details'), opened, (part, open) => { part.open ||= open; });
      put(all(TYPED), typed, (field, words) => { field.value ||= words; });
      put(all(viser.parts.view), scrolled, (view, top) => {
        if (Math.abs(view.scrollTop - top) <= 1) return;
        view.scrollTop = top;
        still = performance.now();  // it may not be as long yet as it was
      });
      setTimeout(settle, STEP);
    };
    settle();
  };
  let old = null;
  const look = () => {
    const question = document.querySelector('.ol-question,.ol-scene');
    if (!question || question === old) return;
    cover.hidden = true;
    watch.disconnect();
    if (left) goBack(left);
    left = null;
  };
  const watch = new MutationObserver(look);
  const tell = why => {
    reason = why;
    speak();
    note.hidden = false;
  };
  line.onLost = () => tell('lost');
  line.onRest = () => tell('rests');
  line.onAnswer = status => {  // a proxy that rewrites Host lets the page through and not its connection; 401 asks for another token
    tell({401: 'token', 421: 'stranger'}[status] ?? 'lost');
  };
  line.onBack = () => {
    note.hidden = true;
    old = document.querySelector('.ol-question,.ol-scene');  // of the connection before: viser keeps it until the new one speaks
    if (old) left = leave();
    cover.hidden = false;
    watch.observe(root, {childList: true, subtree: true});
  };
}
