// Each answer of the server is drawn in one frame; where frames come slowly, with fewer pixels while things move.
() => {
  const page = window.__viserMutable, root = page?.scene?.__r3f?.root;
  if (!root || page.scene.userData.watched) return;
  page.scene.userData.watched = true;
  const SLOW = 34, COARSE = 0.6, REST = 450, TOGETHER = 24, COUNT = 9, opened = performance.now(), gaps = [];
  const MOVES = /^(SceneNodeUpdate|SetPosition|SetOrientation|SetSceneNodeVisibility|Gui\w*Update)Message$/;
  const sharp = devicePixelRatio * (window.observerLabNoCard ? 1.5 : 1);
  let last = 0, slow = !!window.observerLabNoCard, timer = 0, due = 0;
  const draw = dpr => { if (root.getState().viewport.dpr !== dpr) root.getState().setDpr(dpr); };
  const frame = () => { clearTimeout(due); due = 0; root.getState().invalidate(); };
  page.scene.onAfterRender = () => {
    const now = performance.now(), gap = now - last;
    last = now;
    if (slow || gap > 250 || now - opened < 2500) return;
    gaps.push(gap);
    if (gaps.length > COUNT) gaps.shift();
    slow = gaps.length === COUNT && [...gaps].sort((a, b) => a - b)[COUNT >> 1] > SLOW;
  };
  const ask = page.requestRender;
  page.requestRender = () => {
    const quad = page.backgroundMaterial, queue = page.messageQueue;
    if (quad) quad.visible = !!quad.uniforms?.enabled?.value;
    if (queue.length && page.getRenderRequestState === 'ready' && queue.every(m => MOVES.test(m.type))) page.drainMessageQueue?.();
    if (!slow) { ask(); return; }
    draw(COARSE * devicePixelRatio);
    if (window.event?.type?.startsWith('pointer')) due ||= setTimeout(frame, TOGETHER); else frame();
    clearTimeout(timer);
    timer = setTimeout(() => { draw(sharp); root.getState().invalidate(); }, REST);
  };
}
