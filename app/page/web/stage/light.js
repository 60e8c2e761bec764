// Where a graphics card draws, the plant casts a shadow and its metal reflects a bright room. Elsewhere the stage stays as it was sent, with
// a picture of a shadow under the plant. Frames are timed at the start: a card that is too slow gets that as well. The menu changes it.
({lamp, ground, picture, solids, metals}) => {
  if (window.observerLabLight) return;
  const viser = window.observerLabViser, KEY = 'observer-lab-light', SLOW = 14, FRAMES = 4, LOOK = 250;  // ms of a frame; frames; ms
  const HALF = 5.5, FAR = 30, ROOM = 303;  // stage units that a shadow covers; three.js: a picture of all directions, to be reflected
  const GLOSS = {true: [.34, .5], false: [.55, 0]}, PLAIN = [1, 0];  // roughness, metalness: of metal, of the rest, without a card
  const stored = () => { try { return localStorage.getItem(KEY); } catch (error) { return null; } };
  const state = window.observerLabLight = {full: (stored() ?? (window.observerLabNoCard ? 'plain' : 'full')) === 'full', ms: null};
  let lit = null, floor = null, room = null, timed = stored() !== null;
  const sky = like => {  // a white ceiling with two lamps, over a grey floor
    const canvas = Object.assign(document.createElement('canvas'), {width: 256, height: 128}), pen = canvas.getContext('2d');
    const fade = pen.createLinearGradient(0, 0, 0, 128);
    [[0, 235], [.42, 190], [.5, 150], [.62, 165], [1, 175]].forEach(([at, grey]) => fade.addColorStop(at, `rgb(${grey},${grey},${grey + 6})`));
    pen.fillStyle = fade;
    pen.fillRect(0, 0, 256, 128);
    pen.fillStyle = 'white';
    [[30, 14, 46, 18], [150, 20, 30, 14]].forEach(each => pen.fillRect(...each));
    return Object.assign(new like.constructor(canvas), {mapping: ROOM, colorSpace: 'srgb', needsUpdate: true});
  };
  const part = (name, is) => {
    let found = null;
    viser.node(name)?.traverse(each => { found ??= is(each) ? each : null; });
    return found;
  };
  const dress = () => {  // a material that viser has made anew has no gloss yet
    for (const [name, node] of viser.nodes()) {
      if (name.startsWith(solids)) node?.traverse(({material}) => {
        if (!material?.isMeshStandardMaterial || material.userData.full === state.full) return;
        const [roughness, metalness] = state.full ? GLOSS[metals.includes(material.color.getHex())] : PLAIN;
        Object.assign(material, {roughness, metalness});
        material.userData.full = state.full;
      });
    }
  };
  const aim = sun => {
    sun.castShadow = state.full;
    const {shadow} = sun, {camera} = shadow;
    shadow.mapSize.set(2048, 2048);
    Object.assign(shadow, {radius: 5, bias: -.0004, normalBias: .02});
    Object.assign(camera, {left: -HALF, right: HALF, top: HALF, bottom: -HALF, near: .5, far: FAR});
    camera.updateProjectionMatrix();
  };
  const apply = () => {
    const sun = part(lamp, each => each.isDirectionalLight), under = part(ground, each => each.material?.isShadowMaterial);
    const flat = part(picture, each => each.material?.map);
    if (!sun || !under || !flat) return;
    aim(sun);
    floor?.removeFromParent();
    floor = under.clone();
    floor.visible = state.full;
    viser.node(ground).parent.add(floor);
    flat.visible = !state.full;
    room ??= sky(flat.material.map);
    viser.scene().environment = state.full ? room : null;
    viser.scene().environmentIntensity = .6;
    dress();
    lit = sun;
    viser.redraw();
  };
  const measure = () => {  // ms of a whole frame: the card has finished it when its first pixel can be read
    const pen = viser.canvas().getContext('webgl2'), pixel = new Uint8Array(4), begun = performance.now();
    viser.drawNow();
    pen.readPixels(0, 0, 1, 1, pen.RGBA, pen.UNSIGNED_BYTE, pixel);
    return performance.now() - begun;
  };
  const look = () => {
    if (!state.full && !lit) return;  // as it was sent
    if (part(lamp, each => each.isDirectionalLight) !== lit) apply(); else dress();
    if (!lit || timed || !state.full || document.visibilityState !== 'visible') return;
    timed = true;
    measure();  // shaders are made
    state.ms = Math.min(...Array.from({length: FRAMES}, measure));
    if (state.ms > SLOW) {
      state.full = false;
      apply();
    }
  };
  setInterval(() => { if (viser.isDrawn()) look(); }, LOOK);
  state.turn = () => {
    state.full = !state.full;
    timed = true;
    try { localStorage.setItem(KEY, state.full ? 'full' : 'plain'); } catch (error) { /* a frame without storage */ }
    apply();
  };
  document.addEventListener('click', event => { if (event.target?.closest?.('.ol-light')) state.turn(); });
}
