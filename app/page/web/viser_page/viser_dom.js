// Runs before viser's page; it and the two scripts beside it alone know that page. Our other scripts find viser's elements by `parts`, call the
// functions below; our style sheets know an element by the attribute `data-ol-…` that it gets here before it is first painted.
// The names are those of viser 1.1: attributes of its dock and of its own browser tests where there are some, else Mantine's class names.
() => {
  const lab = window.observerLabViser = {}, page = () => window.__viserMutable;
  const FOLDER = '.mantine-Paper-root:has(> .mantine-Paper-root > svg[class*="chevron"])', SHEET = '.mantine-Paper-root[style*="width: 20em"]';

  // --- elements: our name → viser's selector ---------------------------------------------------------------------------
  const parts = lab.parts = {
    stage: 'canvas[data-engine]', slowNote: '#webgl-software-rendering', sceneTree: '[aria-label$="scene tree"]',
    docks: '[data-dock-root]', column: '[data-dock-region=right]', columnHandle: '[data-dock-region-handle=right]', view: '[data-scrollarea-viewport]',
    tab: '[data-dock-tab]', tabs: '.mantine-Tabs-root',
    panelHead: '[data-testid=floating-panel-handle]', panelGrip: '[data-floating-window] :is([data-dock-griphandle],[data-dock-strip])',
    sheet: SHEET, sheetRoom: `${SHEET} [style*="width: 20em"]`, sheetHead: '[style*="height: 3.5em"]:not([style*="min-height"])',
    folder: FOLDER, folderHead: '.mantine-Paper-root > .mantine-Paper-root:has(> svg[class*="chevron"])',
    folderRoom: `${FOLDER} > div:nth-child(2) > div`, opened: 'svg[class*="chevron-up"]',
    row: '.mantine-Flex-root', rowLabel: '.mantine-Flex-root > div:has(> p > label)', text: '.mantine-Text-root',
    button: '.mantine-Button-root', buttonLabel: '.mantine-Button-label', outlined: '.mantine-Button-root[data-variant=outline]',
    iconButton: '.mantine-ActionIcon-root', toolIcon: 'svg:is(.tabler-icon-adjustments,.tabler-icon-arrow-back)',
    slider: '.mantine-Slider-root', sliderTrack: '.mantine-Slider-trackContainer', sliderThumb: '.mantine-Slider-thumb',
    sliderValue: '.mantine-Slider-label', sliderMark: '.mantine-Slider-markLabel',
    hint: '.mantine-Tooltip-tooltip', number: '.mantine-NumberInput-root', numberInput: '.mantine-NumberInput-input', textInput: '.mantine-TextInput-input',
    select: '.mantine-Select-input', checkbox: ':is(.mantine-Checkbox-input,.mantine-Checkbox-inner)', progress: '.mantine-Progress-root',
    dialog: '.mantine-Modal-content', dialogHead: '.mantine-Modal-header', besideDialog: ':is(.mantine-Modal-inner,.mantine-Modal-overlay)',
    notices: '.mantine-Notifications-root', notice: '.mantine-Notification-root', noticeClose: '.mantine-Notification-closeButton',
    chart: '.uplot', chartTitle: '.u-title', chartRoom: '.u-wrap', plot: '.u-over', key: '.u-legend', keyMark: '.u-marker',
  };
  const names = Object.entries(parts).map(([name, selector]) => [`data-ol-${name.replace(/[A-Z]/g, letter => '-' + letter.toLowerCase())}`, selector]);
  const any = Object.values(parts).join(), root = document.documentElement, SCHEME = 'data-mantine-color-scheme';
  const name = element => {
    for (const [attribute, selector] of names) element.toggleAttribute(attribute, element.matches(selector));
    if (element.matches(parts.view) && element.closest(parts.column)) element.tabIndex = 0;  // a column of figures alone scrolls by keys
  };
  const nameAll = element => {
    if (element.matches(any)) name(element);
    element.querySelectorAll(any).forEach(name);
  };
  const theme = () => { root.dataset.olTheme = root.getAttribute(SCHEME) ?? 'light'; };
  new MutationObserver(changes => {
    for (const {type, target, addedNodes} of changes) {
      if (target === root && type === 'attributes') theme();
      else if (type === 'attributes') name(target);
      else for (const node of addedNodes) if (node.nodeType === Node.ELEMENT_NODE) nameAll(node);
    }
  }).observe(document, {childList: true, subtree: true, attributes: true, attributeFilter: ['data-testid', 'data-engine', SCHEME]});
  nameAll(root);

  lab.plots = document.getElementsByClassName('u-over');  // kept up to date by the browser
  lab.openTab = tab => tab.dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter', bubbles: true}));  // as Enter on it would
  lab.search = () => document.documentElement.dispatchEvent(new KeyboardEvent('keydown', {key: 'k', code: 'KeyK', ctrlKey: true, bubbles: true}));
  lab.isOpen = folderHead => !!folderHead.querySelector(`:scope > ${parts.opened}`);

  // --- charts ------------------------------------------------------------------------------------------------------------
  lab.charts = () => Object.values(window.__viserTestpoints?.uplots ?? {}).map(({chart}) => chart);
  lab.strokeOf = (chart, series) => series._stroke ?? series.stroke?.(chart);
  lab.afterDrawing = (chart, act) => { (chart.hooks.draw ??= []).push(act); };

  // --- messages: to the server, and to viser's page as if they had just come from there ---------------------------------------
  lab.changed = (widget, updates) => ({type: 'GuiUpdateMessage', uuid: widget, updates});
  lab.tell = (widget, value) => page().sendMessage(lab.changed(widget, {value}));
  lab.answerStorage = (request, value) => page().sendMessage({type: 'LocalStorageGetItemResponseMessage', value, error: null, request_uuid: request});
  lab.show = messages => {
    page().messageQueue.push(...messages);
    page().requestRender();
  };
  lab.moved = (owner, name, prop, value) => {
    if (prop === 'position') return {type: 'SetPositionMessage', name, owner, position: value};
    if (prop === 'wxyz') return {type: 'SetOrientationMessage', name, owner, wxyz: value};
    if (prop === 'visible') return {type: 'SetSceneNodeVisibilityMessage', name, owner, visible: value};
    return {type: 'SceneNodeUpdateMessage', name, owner, updates: {[prop]: value}};
  };
  lab.updated = (kind, name, owner, updates) => (kind === 'scene' ? {type: 'SceneNodeUpdateMessage', name, owner, updates}
    : {...lab.changed(name, updates), ...(kind === 'command' && {type: 'CommandUpdateMessage'})});
  const REMOVED = {modal: 'GuiCloseModalMessage', command: 'RemoveCommandMessage'};
  lab.removed = (kind, name, owner) => (kind === 'scene' ? {type: 'RemoveSceneNodeMessage', name, owner}
    : {type: REMOVED[kind] ?? 'GuiRemoveMessage', uuid: name});
  lab.told = ({horizon, clock, words, digits, slider, step}, t, slides = true) => {  // what the clock and the slider of a run say at a time
    const said = words.replaceAll('\ue000', (t / horizon).toFixed(4)).replaceAll('\ue001', t.toFixed(digits));
    const value = Math.min(Number((Math.round(t / step) * step).toFixed(9)), horizon);
    return [lab.changed(clock, {content: said}), ...(slides ? [lab.changed(slider, {value})] : [])];
  };
  lab.lookFrom = (from, at, angle) => lab.show([{type: 'SetCameraUpDirectionMessage', position: [0, 0, 1], initial: false},
    {type: 'SetCameraPositionMessage', position: from, initial: false}, {type: 'SetCameraLookAtMessage', look_at: at, initial: false},
    {type: 'SetCameraFovMessage', fov: angle, initial: false}]);
  const MOVES = /^(SceneNodeUpdate|SetPosition|SetOrientation|SetSceneNodeVisibility|Gui\w*Update)Message$/;
  lab.takeUp = movesAlone => {  // what waits for the next frame, now
    const queue = page().messageQueue;
    if (queue.length && page().getRenderRequestState === 'ready' && (!movesAlone || queue.every(({type}) => MOVES.test(type)))) page().drainMessageQueue?.();
  };

  // --- the stage -----------------------------------------------------------------------------------------------------------
  const view = () => page().scene.__r3f.root.getState(), held = node => (node && 'current' in node ? node.current : node);
  lab.isDrawn = () => !!page()?.scene?.__r3f?.root;
  lab.scene = () => page()?.scene;
  lab.canvas = () => page()?.canvas;
  lab.node = name => held(page().nodeRefFromName[name]);
  lab.onScreen = name => {  // the pixel at which a node is drawn; null where it is not
    const node = lab.node(name), canvas = lab.canvas();
    if (!node || !canvas) return null;
    node.updateWorldMatrix(true, false);
    const at = node.position.clone().setFromMatrixPosition(node.matrixWorld).project(page().camera), box = canvas.getBoundingClientRect();
    return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
  };
  lab.onScreenOf = (name, [x, y, z]) => {  // where in the canvas, as shares of it, a point of a node's own frame is drawn
    const node = lab.node(name), at = node.position.clone().set(x, y, z);
    node.updateWorldMatrix(true, false);
    node.localToWorld(at).project(page().camera);
    return [(at.x + 1) / 2, (1 - at.y) / 2];
  };
  lab.nodes = () => Object.entries(page().nodeRefFromName).map(([name, node]) => [name, held(node)]);
  lab.tellCamera = () => page()?.sendCamera?.();
  lab.redraw = () => page()?.requestRender?.();
  lab.drawFrame = () => view().invalidate();
  lab.drawNow = () => view().advance(performance.now(), true);
  lab.onSize = act => page().scene.__r3f.root.subscribe((now, before) => {  // of the canvas
    if (now.size !== before.size) act();
  });
  lab.resolution = () => view().viewport.dpr;
  lab.setResolution = dpr => view().setDpr(dpr);
  lab.afterFrames = act => { page().scene.onAfterRender = act; };
  lab.afterFrame = act => {  // once
    const scene = page().scene, seen = scene.onAfterRender;
    scene.onAfterRender = (...all) => {
      seen?.(...all);
      scene.onAfterRender = seen;
      act();
    };
  };
  lab.onRedraw = draw => {  // instead of what viser does when something is to be drawn, which `draw` is given
    const ask = page().requestRender;
    page().requestRender = () => draw(ask);
  };
  lab.hideEmptyBackground = () => {
    const quad = page().backgroundMaterial;
    if (quad) quad.visible = !!quad.uniforms?.enabled?.value;
  };
  lab.keepCamera = ({low, high, steepest}) => {  // what it looks at within a box, itself no lower than an angle from the vertical
    const control = page()?.cameraControl;
    if (!control) return;
    const within = control._boundary.clone(), from = control.getPosition(), to = control.getTarget();
    within.min.set(...low);
    within.max.set(...high);
    control.maxPolarAngle = steepest;
    control.setBoundary(within);  // takes what is looked at now inside
    control.setLookAt(from.x, from.y, from.z, to.x, to.y, to.z, false);
  };
  const ROUND = .3;  // of a label's height: the radius of its corners
  const roundCorners = skin => {  // of the quads behind labels; their size in pixels comes from how fast a corner's share changes
    const place = 'varying vec2 observerLabPlace;\n';
    skin.vertexShader = place + skin.vertexShader.replace('vAlpha = visibility;', 'vAlpha = visibility;\n  observerLabPlace = position.xy;');
    skin.fragmentShader = `${place}float observerLabInside() {
  vec2 size = 1.0 / max(fwidth(observerLabPlace), vec2(1e-5));
  float radius = ${ROUND} * min(size.x, size.y);
  vec2 beyond = abs(observerLabPlace - 0.5) * size - 0.5 * size + radius;
  return clamp(0.5 + radius - length(max(beyond, 0.0)), 0.0, 1.0);
}
${skin.fragmentShader.replace('* vAlpha)', '* vAlpha * observerLabInside())')}`;
  };
  const INKS = [['vec4(0.0, 0.0, 0.0,', 'observerLabInk'], ['vec4(1.0, 1.0, 1.0,', 'observerLabGround']];
  lab.colourLabels = (ink, ground) => {  // two uniforms {value: [r, g, b]} in the place of viser's black and white
    const dress = ({material: skin}) => {
      if (!skin?.fragmentShader?.includes('vAlpha')) return false;
      for (const [k, [written, name]] of INKS.entries()) {
        if (!skin.fragmentShader.includes(`gl_FragColor = ${written}`)) continue;
        skin.uniforms[name] = [ink, ground][k];
        skin.fragmentShader = `uniform vec3 ${name};\n${skin.fragmentShader.replace(written, `vec4(${name},`)}`;
        if (name === 'observerLabGround') roundCorners(skin);
        skin.needsUpdate = true;
      }
      return true;
    };
    lab.scene()?.traverse(part => {
      if (!dress(part) || lab.labels === part.parent) return;
      lab.labels = part.parent;  // where viser puts one more mesh for each size of letters
      lab.labels.addEventListener('childadded', ({child}) => dress(child));
    });
  };

  // --- a run by the frames of the browser --------------------------------------------------------------------------------------
  lab.runner = (show, end, rate) => {  // `show(t)` at each frame until `end()`, at `rate()` of the run's seconds in one
    const STALL = .25, run = {now: 0, playing: false};  // s that one frame covers at most
    let before = 0, wake = 0;
    const tick = stamp => {
      run.now = Math.min(run.now + Math.min(Math.max(stamp - before, 0) / 1000, STALL) * rate(), end());
      before = Math.max(stamp, before);
      if (run.now >= end()) run.go(false); else wake = requestAnimationFrame(tick);
      show(run.now);
    };
    run.go = wanted => {
      cancelAnimationFrame(wake);
      run.playing = wanted;
      before = performance.now();
      if (wanted) wake = requestAnimationFrame(tick);
    };
    return run;
  };
  lab.farther = (from, aim, shape) => {  // a window that is narrower than a picture's `shape` looks from farther off
    const {clientWidth: wide, clientHeight: high} = lab.canvas() ?? {}, times = wide && high ? Math.max(1, shape / Math.max(wide / high, .2)) : 1;
    return [from.map((each, k) => aim[k] + times * (each - aim[k])), times];
  };

  // --- before viser's page runs ----------------------------------------------------------------------------------------------
  lab.play = (recording, dark) => {
    window.__VISER_EMBED_DATA__ = recording;
    window.__VISER_EMBED_CONFIG__ = {darkMode: dark};
  };
  lab.sheetWithin = query => {  // its sheet for phones in other windows than its own query says
    const theirs = window.matchMedia;
    window.matchMedia = asked => theirs.call(window, asked === '(max-width: 36em)' ? query : asked);
  };
  lab.onConnecting = () => {};
  lab.onConnection = () => true;  // is given 'connected' or 'closed' and what more is said; whether viser's page may hear of it
  lab.onBatch = () => true;  // is given the messages of each batch as it comes, drawn or not; whether viser's page may hear of it
  lab.onSend = () => true;  // is given each message to the server; whether it goes there now
  lab.server = null;  // the address to connect to instead of viser's own idea
  lab.files = null;  // what stands in a server's place: `open(give)` may give batches of messages, `take(message)` gets what the page says
  let worker = null;  // which holds the connection
  lab.send = message => { worker.postRaw({type: 'send', message}); };
  lab.reconnect = () => { worker.postRaw(lab.server === null ? {type: 'retry'} : {type: 'set_server', server: lab.server}); };
  window.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      lab.onConnecting();
      this.addEventListener('message', event => {
        if (this !== worker) return;
        const {type, messages} = event.data ?? {};
        if (!type) return;
        if (!(type === 'message_batch' ? lab.onBatch(messages) : lab.onConnection(type, event.data))) event.stopImmediatePropagation();
      });
    }
    postRaw(said) { super.postMessage(said); }
    postMessage(said, ...more) {
      if (lab.files && ['set_server', 'send', 'retry', 'close'].includes(said?.type)) {
        const give = (type, messages) => this.dispatchEvent(new MessageEvent('message', {data: {type, messages}}));
        if (said.type === 'set_server') lab.files.open(messages => give('message_batch', messages), () => give('connected'));
        if (said.type === 'send') lab.files.take(said.message);
        return;
      }
      if (said?.type === 'set_server') worker = this;
      if (this === worker && said?.type === 'retry') return;  // viser's own, every second and only while the page has the focus
      if (this === worker && said?.type === 'send' && !lab.onSend(said.message)) return;
      super.postMessage(lab.server !== null && said?.type === 'set_server' ? {...said, server: lab.server} : said, ...more);
    }
  };
  lab.buildWhenOpened = opened => {  // of a folder nothing before `opened` holds its id; another version of viser builds all of it as before
    const add = Node.prototype.appendChild, built = new RegExp(String.raw`expanded:(\w+)&&!(\w+),children:(\(0,\w+\.jsx\)\(\w+,\{pt:.0\.2em.,`
      + String.raw`children:\(0,\w+\.jsx\)\(\w+\.Provider,\{value:\{\.\.\.(\w+),folderDepth:\4\.folderDepth\+1\},children:\(0,\w+\.jsx\)`
      + String.raw`\(\4\.GuiContainer,\{containerUuid:(\w+)\}\)\}\)\}\))`);
    lab.opened = opened;
    Node.prototype.appendChild = function (part) {
      if (part.tagName === 'SCRIPT' && part.type === 'module') {
        Node.prototype.appendChild = add;
        const theirs = part.textContent;
        part.textContent = theirs.replace(built, 'expanded:$1&&!$2,children:(observerLabViser.opened[$5]||=$1&&!$2)?$3:null');
        opened.spared = part.textContent !== theirs;
      }
      return add.call(this, part);
    };
  };
}
