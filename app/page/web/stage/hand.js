// Shows once where a scene wants a hand, by a pulsing ring: on a cross of the stage, on a widget, or on a button of the run. It goes
// when something is pressed, or the scene is left.
({scene, node, widget, button}) => {
  const viser = window.observerLabViser, lab = window.observerLabHand ??= {shown: new Set(), scene: ''};
  Object.assign(lab, {node, widget, button});
  if (scene === lab.scene) return;
  lab.scene = scene;
  lab.end?.();
  if (!scene || lab.shown.has(scene)) return;
  const mark = Object.assign(document.createElement('div'), {className: 'ol-hand', hidden: true});
  mark.setAttribute('aria-hidden', 'true');
  mark.innerHTML = '<svg viewBox="0 0 24 26"><path d="M9 13V4a2 2 0 0 1 4 0v7l5 1.4a2.6 2.6 0 0 1 2 2.6v2.5a6.5 6.5 0 0 1-6.5 6.5h-1.6'
    + 'a6.5 6.5 0 0 1-5-2.3L3.4 17.6a1.8 1.8 0 0 1 2.6-2.5l3 2.6z"/></svg>';
  document.body.append(mark);
  const middle = element => {
    const box = element?.checkVisibility() && element.getBoundingClientRect();
    return box && box.width ? [box.x + box.width / 2, box.y + box.height / 2] : null;
  };
  const place = () => {
    if (lab.node) return viser.onScreen(lab.node);
    if (!lab.widget) return middle([...document.querySelectorAll(viser.parts.button)].find(each => each.textContent.trim() === lab.button));
    const held = document.getElementById(lab.widget);
    return middle(held?.querySelector('[role=slider]') ?? held);
  };
  const follow = () => {
    const at = document.querySelector('.ol-card') && !document.querySelector(viser.parts.dialog) ? place() : null;
    const seen = !!at && at[0] > 0 && at[1] > 0 && at[0] < innerWidth && at[1] < innerHeight;
    const top = seen && document.elementFromPoint(...at), free = !!top && (lab.node ? top === viser.canvas() : !top.closest('.ol-cover'));
    mark.hidden = !free;
    if (!free) return;
    lab.shown.add(scene);
    [mark.style.left, mark.style.top] = at.map(pixel => `${Math.round(pixel)}px`);
  };
  const timer = setInterval(follow, 100), end = () => {
    clearInterval(timer);
    mark.remove();
    removeEventListener('pointerdown', done, {capture: true});
    lab.end = null;
  };
  const done = () => { if (!mark.hidden) end(); };
  addEventListener('pointerdown', done, {capture: true});
  lab.end = end;
  follow();
}
