// Runs before viser's page: stands in the place of the server with states that were recorded. A state is a patch on the base of its look,
// so any may follow any; what a hand does leads to the state that was recorded for it, or to the nearest.
({lessons, looks, words, web, speeds, shapes, board, stops, lecture}) => {
  const viser = window.observerLabViser, {load, read} = window.observerLabPacked, OWNER = '0', STEP = 100, KEY = 'observer-lab-published', root = document.documentElement;
  const keep = () => { try { localStorage.setItem(KEY, JSON.stringify(memory)); } catch (error) { /* a frame without storage */ } };
  const kept = () => { try { return JSON.parse(localStorage.getItem(KEY)) ?? {}; } catch (error) { return {}; } };
  const calm = () => matchMedia('(prefers-reduced-motion: reduce)').matches;

  // --- which page: the address says it, else what was open last ------------------------------------------------------------
  const asked = new URLSearchParams(location.search), memory = {language: '', theme: '', lesson: '', done: {}, ...kept()};
  const one = (wanted, all) => wanted.find(each => all.includes(each)) ?? all[0], parts = k => [...new Set(looks.map(look => look.split('-')[k]))];
  const lesson = one([asked.get('lesson'), memory.lesson], lessons), language = one([asked.get('lang'), memory.language], parts(0));
  const theme = one([asked.get('theme'), memory.theme, matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light'], parts(1));
  const width = one([innerWidth > 896 ? 'wide' : 'phone'], parts(2)), look = `${language}-${theme}-${width}`, said = words[language];
  const done = memory.done[lesson] ??= {};  // scene → the state in which it was done
  root.lang = web[language];
  const address = changes => `${location.pathname}?${new URLSearchParams(Object.entries(
    {lesson, lang: language, theme, scene: base?.scenes[at]?.id, stop: stop > 0 ? stop : '', ...changes}).filter(([, value]) => value))}`;
  const leave = changes => {
    keep();
    location.assign(address(changes));
  };

  const ahead = Promise.all([look, language].map(file => load(`${lesson}/${file}`)));  // while viser's page begins

  // --- what stands -------------------------------------------------------------------------------------------------------------
  let base = null, ground = new Map(), props = new Map(), at = 0, scene = null, state = {over: new Map(), held: {}}, touched = new Set();
  let give = () => {}, speed = speeds.indexOf(1), turn = 0, overlay = null, drawn = '', moving = {}, stop = Number(asked.get('stop') ?? -1);
  const id = () => base.scenes[at].id;
  const total = (key, over = state.over) => (over.has(key) ? over.get(key) : ground.get(key));
  const here = k => stops[k]?.[0] === lesson && stops[k][1] === id(), stopHere = () => (here(stop) ? stop : stops.findIndex((_, k) => here(k)));
  const dressed = (key, value) => {  // what depends on the way that somebody has come
    if (base?.scenes[at].lacks && value?.includes?.('class="ol-way"')) value = value.replace('<div class="ol-way"', `<p class="ol-note">${said.lacks}</p>$&`);
    if (base && typeof value === 'string' && value.includes('class="ol-way"') && stopHere() >= 0) return value
      .replace(/data-value="mode:[^<]*/, `data-value="turn:1">${said.next}`).replace(/(<div class="ol-way">)(<button[^>]*data-to="([^"]*)")(?!.*"turn:-1")/,
        `$1<button type="button" class="ol-do" data-to="$3" data-value="turn:-1">${said.back}</button>$2`);
    if (typeof value === 'string' && value.includes('class="ol-dot"')) return value.replace(/(data-value="scene:(\d+)"[^>]*?)( data-done)?>/g,
      (all, head, k) => `${head}${done[base.scenes[k]?.id] ? ' data-done' : ''}>`);
    if (drawn && typeof value === 'string' && value.includes('</svg>') && value.includes(drawn.mark)) return value.replace('</svg>', `${drawn.path}</svg>`);
    if (key.endsWith('\noptions') && value?.includes?.(said.play)) return value.map(each => (each === said.play && player.playing ? said.pause : each));
    return value;
  };
  const named = entity => [entity.slice(0, entity.indexOf(':')), entity.slice(entity.indexOf(':') + 1)];
  const remove = entity => viser.removed(...named(entity), OWNER), update = (entity, updates) => viser.updated(...named(entity), OWNER, updates);
  const byEntity = keys => {  // entity → its properties
    const found = new Map();
    for (const [entity, prop] of [...keys].map(key => key.split('\n'))) found.set(entity, [...found.get(entity) ?? [], prop]);
    return found;
  };
  const messages = (keys, over) => {  // that make these places stand as in a state
    const gone = [], made = [], moved = [], last = [];
    for (const [entity, names] of byEntity(keys)) {
      const head = total(`${entity}\n`, over), was = total(`${entity}\n`), plain = {};
      const create = names.includes('') && head && (over.size === 0 || JSON.stringify(head) !== JSON.stringify(was));
      if (head === undefined && entity !== 'gui:viser-control-panel') {
        if (entity.includes(':') && was !== undefined) gone.push(remove(entity));
      } else if (!/^(gui|scene|modal|command|notification):/.test(entity)) last.push(head);
      else {
        const special = [], own = create ? [...over.keys()].filter(key => key.startsWith(`${entity}\n`)).map(key => key.split('\n')[1]) : [];
        for (const prop of create ? new Set([...props.get(entity) ?? [], ...own, ...names]) : names) {
          const key = `${entity}\n${prop}`, value = dressed(key, total(key, over));
          if (value === undefined || prop === '') continue;
          if (prop.startsWith('@')) special.push(value); else plain[prop] = value;
        }
        if (create) made.push({...head, ...('value' in plain && {value: plain.value}), props: plain});
        else if (Object.keys(plain).length) moved.push(update(entity, plain));
        moved.push(...special);
      }
    }
    return [...gone, ...made, ...moved, ...last.map(farther)];
  };
  const farther = message => (message.type === 'SetCameraPositionMessage' && viser.canvas()
    ? {...message, position: viser.farther(message.position, total('SetCameraLookAtMessage\n').look_at, shapes[width])[0]} : message);
  const show = (next, camera = false) => {
    if (next.done) {
      done[id()] = next.name;
      keep();
    }
    const keys = [...new Set([...state.over.keys(), ...next.over.keys(), ...touched])];
    const wanted = new Set(keys.filter(key => touched.has(key) || total(key) !== total(key, next.over)));
    if (camera) [...ground.keys()].filter(key => key.startsWith('SetCamera')).forEach(key => wanted.add(key));
    const batch = messages(wanted, next.over);
    state = next;
    touched = new Set();
    give(batch);
  };

  // --- the run -------------------------------------------------------------------------------------------------------------------
  const SENT = {position: '@SetPositionMessage', wxyz: '@SetOrientationMessage'}, KINDS = ['position', 'wxyz', 'scale', 'color', 'points', 'text'];
  const frames = run => run.channels.map(([name, kind, many, step, deltas, first]) => {  // of 16 bits, as their sums wrap
    const sums = scene.arrays[deltas].slice(), other = scene.arrays[first];
    for (let k = 0; k < sums.length; k += 1) sums[k] += (other ? other[k] : 0) + (k % run.count ? sums[k - 1] : 0);
    return {name: run.names[name], kind: KINDS[kind], at: k => Array.from({length: many}, (_, part) => sums[part * run.count + k] * step)};
  });
  const pose = t => {
    if (!state.run) return;
    player.now = t;
    if (moving.run !== state.run) moving = {run: state.run, times: scene.arrays[state.run.times], frames: frames(state.run)};
    const told = {...state.told, words: state.told.words[speed]}, k = Math.max(moving.times.findLastIndex(each => each <= t + 1e-6), 0);
    const batch = moving.frames.map(({name, kind, at: now}) => {
      touched.add(`scene:${name}\n${SENT[kind] ?? kind}`);
      return viser.moved(OWNER, name, kind, kind === 'points' ? new Float32Array(now(k)) : kind === 'text' ? String.fromCodePoint(...now(k)) : now(k));
    });
    touched.add(`gui:${told.clock}\ncontent`).add(`gui:${told.slider}\nvalue`);
    give([...batch, ...viser.told(told, t)]);
  };
  const label = () => ground.forEach((_, key) => {  // play or pause on the first button of the run
    if (!key.endsWith('\noptions') || !total(key)?.includes?.(said.play)) return;
    touched.add(key);
    give([update(key.split('\n')[0], {options: dressed(key, total(key))})]);
  });
  const player = viser.runner(t => { pose(t); if (!player.playing) label(); }, () => state.run.end, () => state.run.rate * speeds[speed]);
  const go = (wanted, from = player.now) => {
    if (!state.run || (!wanted && !player.playing)) return;
    player.go(wanted);
    label();
    pose(wanted && (from >= state.run.end - 1e-9 || [state.t, state.rest].includes(from)) ? 0 : from);
  };

  // --- scenes --------------------------------------------------------------------------------------------------------------------
  const open = async k => {
    const [text, spoken, arrays] = await Promise.all([look, language, 'arrays'].map(file => load(`${lesson}/${base.scenes[k].id}/${file}`)));
    const patch = read(spoken, arrays.arrays), full = each => ({...each, over: patch(each.patch), steps: each.steps.map(patch),
      run: arrays.runs[each.run], told: spoken.values[each.told]});
    text.full ??= Object.fromEntries(text.states.map(each => [each.name, full(each)]));
    return {states: text.full, knobs: text.knobs, sketch: text.sketch, arrays: arrays.arrays};
  };
  const enter = async (k, push = true) => {
    if (!base.scenes[k]) return;
    const mine = turn += 1, next = await open(k);
    if (mine !== turn) return;
    go(false);
    [scene, at, drawn, memory.lesson] = [next, k, '', lesson];
    const {entry} = scene.states, again = scene.states[done[id()]] ?? entry;
    history[push ? 'pushState' : 'replaceState']({scene: k}, '', address());
    if (again === entry && entry.steps.length) await perform(entry);
    else {
      show(again, true);
      pose(again === entry ? entry.t : again.rest);
    }
    cover.hidden = true;
  };
  const perform = async next => {  // where calm is asked for an answer rests at once; a run that a hand has started plays
    const mine = turn += 1;
    go(false);
    for (const over of calm() ? [] : next.steps) {
      show({...next, over, done: false}, true);
      await new Promise(wake => setTimeout(wake, STEP));
      if (mine !== turn) return;
    }
    show(next);
    if (next.runs && (/^(play|kick|pull)/.test(next.name) || !calm())) go(true, 0); else pose(next.runs ? next.rest : next.t);
  };
  const reach = name => scene.states[name] && perform(scene.states[name]);
  const follow = by => {  // the stops of a lecture where this is one, else the path
    stop = stopHere();
    if (stop < 0) return enter(at + by);
    if (!stops[stop + by]) return location.assign(lecture[language]);
    const [there, name] = stops[stop += by];
    return there === lesson ? enter(base.scenes.findIndex(each => each.id === name)) : leave({lesson: there, scene: name});
  };

  // --- knobs, poles and hands snap -------------------------------------------------------------------------------------------------
  const states = () => Object.values(scene.states), alone = knob => states().filter(({held}) => Object.keys(held).length === 1 && knob in held);
  const far = (one, other) => (typeof one === 'number' ? Math.abs(one - other)
    : Array.isArray(one) ? Math.hypot(...one.map((each, k) => each - other[k])) : Number(one !== other));
  const nearest = (all, distance) => all.reduce((one, other) => (distance(other) < distance(one) ? other : one));
  const move = (best, knob) => {  // one knob to one of its computed values, the others as they are where that was computed too
    const held = {...state.held, ...best.held};
    if (best === scene.states.entry) delete held[knob];
    const same = each => Object.keys(each.held).length === Object.keys(held).length && Object.entries(held).every(([name, k]) => each.held[name] === k);
    const next = states().find(each => each.name.startsWith('knob:') && same(each)) ?? best;
    turn += 1;
    go(false);
    show(next);
    pose(Math.min(player.now, next.run?.end ?? 0));
  };
  const turnKnob = (knob, place, value) => {
    const {entry} = scene.states, moved = alone(knob).filter(each => far(total(place, each.over), total(place, entry.over)) > 0);
    touched.add(place);
    move(nearest([entry, ...moved], each => far(total(place, each.over), value)), knob);
  };
  let grabbed = null, force = 0, from = [];
  const grab = ({phase, name, end_screen_pos: [, y], start_screen_pos: [, before]}) => phase === 'end' && /^\/(plant|hand)/.test(name)
    && pull(Object.keys(scene.states).find(each => each.startsWith('pull:'))?.split(':')[1], 3 * (before - y));
  const hold = (phase, name, taken, way) => {  // a pole of a board to the computed place that is nearest by `way`
    const key = `scene:${name}\nbatched_positions`, points = over => {
      const all = total(key, over) ?? [];
      return Array.from({length: all.length / 3}, (_, k) => [...all.slice(3 * k, 3 * k + 3)]);
    };
    const home = points(scene.states.entry.over), away = (all, point) => !all.some(each => far([each[0], each[2]], [point[0], point[2]]) < 1e-3);
    const lost = over => home.filter(point => away(points(over), point)).map(String);
    if (phase === 'start' || !grabbed) {
      const point = taken(points(state.over)), mine = point && !away(home, point) ? [String(nearest(home, each => far(each, point)))] : lost(state.over);
      grabbed = states().filter(each => Object.keys(each.held).length === 1 && lost(each.over).some(each => mine.includes(each)));
    }
    const reached = over => Math.min(...points(over).filter(point => away(home, point)).map(way));
    if (grabbed.length) {
      const best = nearest(grabbed, each => reached(each.over));
      if (best !== state && reached(best.over) < Infinity) move(best, Object.keys(best.held)[0]);
    }
    if (phase === 'end') grabbed = null;
  };
  const drag = ({phase, name, instance_index: index, end_screen_pos: at}) =>
    hold(phase, name, all => all[index ?? 0], point => far(viser.onScreenOf(name, point), at));
  const slide = ([id, k, axis], share, ended) => {  // by keys: beyond where the pole stood, the way that the slider went
    const all = [...document.querySelectorAll(`[data-slider^="${id}.${k}."]`)], asked = Number(axis);
    if (!grabbed) from = all.map(each => (window.observerLabSlide.values[each.dataset.slider] - each.min) / (each.max - each.min));
    const stood = from.map((part, a) => board[a] * (a ? part : part - .5)), to = [...stood], sides = point => [point[0], point[2]];
    to[asked] = board[asked] * (asked ? share : share - .5);
    const side = Math.sign(to[asked] - stood[asked]), beyond = point => side * (sides(point)[asked] - stood[asked]) > 1e-3;
    hold(ended ? 'end' : 'move', `/board/${id}/grips`, here => nearest(here, each => far(sides(each), stood)),
      point => (beyond(point) ? far(sides(point), to) : Infinity));
    touched.add('slide\n');
    if (ended) show(state);  // the slider stands where the pole does
  };
  const pull = (knob, share) => {
    const all = states().filter(({name}) => name.startsWith(`pull:${knob}:`)), size = ({name}) => Number(name.split(':')[2]);
    if (all.length && Math.abs(share) > .02) perform(nearest(all, each => Math.abs(size(each) - share)));
  };
  const sketch = heights => {  // the option whose drawing is nearest, and the hand's own line beside it
    const {options, mark} = scene.sketch ?? {}, shares = heights.split(',').map(Number);
    if (options?.[0].length !== shares.length) return;
    drawn = {mark, path: document.querySelector('.ol-sketched').outerHTML};
    reach(`option:${options.indexOf(nearest(options, option => option.reduce((sum, each, k) => sum + Math.abs(each - shares[k]), 0)))}`);
  };

  // --- what a hand does ----------------------------------------------------------------------------------------------------------
  const dialogs = () => Promise.all([look, language].map(file => load(`${lesson}/${file}-dialogs`))).then(([mine, spoken]) => base.overlays ??=
    Object.fromEntries(Object.entries(mine.overlays).map(([name, pairs]) => [name, read(spoken)(pairs)])));
  const dialog = async name => {  // is shown instead of the one that stands; the same again, or none: nothing is
    const next = name ? (await dialogs())[name] : null, own = from => [...from ?? []].filter(([key]) => total(key) === undefined);
    const entities = own(overlay).map(([key]) => key).filter(key => key.endsWith('\n')).map(key => key.slice(0, -1));
    give([...entities.filter(each => each.startsWith('modal:')), ...entities.filter(each => !each.startsWith('modal:'))].map(remove));
    overlay = next === overlay ? null : next;
    const shown = new Map(own(overlay));
    give(messages(shown.keys(), shown));
  };
  const close = () => dialog(''), other = (all, here) => all[(all.indexOf(here) + 1) % all.length];
  const toLesson = name => (lessons.includes(name) && name !== lesson ? leave({lesson: name, scene: ''}) : close());
  const acts = {
    turn: by => follow(Number(by)), scene: k => enter(Number(k)), option: k => reach(`option:${k}`), sketch, lesson: toLesson, close,
    play: () => (!player.playing && !done[id()] && reach('play')) || go(!player.playing), kick: () => reach('kick'),
    rewind: () => { go(false); pose(0); }, kept: () => reach(done[id()]), reset: () => { delete done[id()]; enter(at, false); },
    slower: () => { speed = Math.max(speed - 1, 0); pose(player.now); }, faster: () => { speed = Math.min(speed + 1, speeds.length - 1); pose(player.now); },
    language: () => { memory.language = other(parts(0), language); leave({lang: memory.language}); },
    theme: () => { memory.theme = other(parts(1), theme); leave({theme: memory.theme}); },
    course: () => dialog('course'), terms: () => dialog('terms'), help: () => dialog('help'),
    page: by => toLesson(lessons[lessons.indexOf(lesson) + Number(by)] ?? lesson), view: () => show(state, true),
  };
  const act = word => {
    const [name, ...rest] = word.split(':');
    acts[name]?.(rest.join(':'));
  };
  const heard = ({uuid, updates: {value}}) => {
    const entity = `gui:${uuid}`, made = (total(`${entity}\n`) ?? overlay?.get(`${entity}\n`))?.type;
    const knob = Object.entries(scene.knobs).find(([, widgets]) => widgets.includes(entity)), pulled = /^([\w.]+):(-?[\d.e-]+):([01]):\d+$/.exec(value);
    if (uuid === state.told?.slider) { go(false); pose(Number(value)); }
    else if (knob) turnKnob(knob[0], `${entity}\nvalue`, value);
    else if (made === 'GuiButtonMessage') close();
    else if (made !== 'GuiButtonGroupMessage') return;
    else if (pulled?.[1].includes('.')) slide(pulled[1].split('.'), Number(pulled[2]), pulled[3] === '1');
    else if (pulled) { if (pulled[3] === '1') { pull(pulled[1], Number(pulled[2]) || force); force = 0; } else force = Number(pulled[2]) || force; }
    else if (overlay?.has(`${entity}\n`)) toLesson(value);
    else act((Object.entries(said).find(([, label]) => label === value)?.[0] ?? String(value)).replace('pause', 'play'));
  };
  const cover = Object.assign(document.createElement('div'), {className: 'ol-cover', innerHTML: '<b>Observer Lab</b>'}), came = location.href;
  root.append(cover);
  viser.onConnecting = () => history.replaceState(history.state, '', came);  // where viser's page has put the server it looks for
  const begin = async (send, connected) => {
    give = batch => batch.length && send(batch);
    const [mine, spoken] = await ahead, patch = read(spoken);
    base = mine;
    ground = patch(base.base);
    props = byEntity(ground.keys());
    connected();
    give([...messages(ground.keys(), new Map()), viser.moved('', '/WorldAxes', 'visible', false)]);
    await enter(Math.max(base.scenes.findIndex(each => each.id === asked.get('scene')), 0), false);
  };
  viser.files = {
    open: begin,
    take: message => {
      if (!scene) return;
      if (message.type === 'GuiUpdateMessage' && 'value' in (message.updates ?? {})) heard(message);
      else if (message.type === 'SceneNodeDragMessage') (/\/grips$/.test(message.name) ? drag : grab)(message);
      else if (message.type === 'CommandTriggerMessage') act(base.commands[total(`command:${message.uuid}\nlabel`)] ?? '');
    },
  };
  addEventListener('popstate', event => { if (event.state?.scene !== undefined) enter(event.state.scene, false); });
}
