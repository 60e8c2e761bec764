// Says viser's own words in the page's language, wherever they stand or come to stand: its buttons, hints and fields.
({words}) => {
  const named = ['title', 'aria-label', 'placeholder'];
  const page = window.observerLabWords ??= {said: new WeakMap()};
  page.words = words;
  const put = (thing, place, now, write) => {
    const said = page.said.get(thing) ?? page.said.set(thing, {}).get(thing), old = said[place];
    const english = old && now === old.shown ? old.english : now;  // what is no longer as we wrote it is viser's again
    if (!Object.hasOwn(page.words, english)) return;
    const shown = page.words[english];
    said[place] = {english, shown};
    if (now !== shown) write(shown);
  };
  const text = node => put(node, 'text', node.data, words => { node.data = words; });
  const names = element => named.forEach(name => element.hasAttribute(name)
    && put(element, name, element.getAttribute(name), words => element.setAttribute(name, words)));
  const all = root => {
    if (root.nodeType === Node.TEXT_NODE) return text(root);
    if (root.nodeType !== Node.ELEMENT_NODE) return;
    names(root);
    root.querySelectorAll(named.map(name => `[${name}]`).join()).forEach(names);
    const walk = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) text(walk.currentNode);
  };
  page.watch?.disconnect();
  page.watch = new MutationObserver(changes => changes.forEach(({type, target, addedNodes}) =>
    type === 'attributes' ? names(target) : type === 'characterData' ? text(target) : addedNodes.forEach(all)));
  page.watch.observe(document.body, {childList: true, subtree: true, characterData: true, attributes: true, attributeFilter: named});
  all(document.body);
}
