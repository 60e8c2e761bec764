// Runs before the published page: reads its files, which are scripts, so that a page opened from a folder may load them too.
({folder}) => {
  const waiting = {}, loaded = {}, TYPES = {'<f4': Float32Array, '<i4': Int32Array, '<u4': Uint32Array, '<i2': Int16Array};
  window.observerLabData = (name, text) => waiting[name]?.(text);
  const load = name => loaded[name] ??= new Promise((take, fail) => {
    waiting[name] = take;
    const onerror = () => fail(Error(`no file ${name}`));
    document.head.append(Object.assign(document.createElement('script'), {src: `${folder}/${name}.js`, onerror}));
  }).then(async text => {
    const packed = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    const bytes = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
    const size = Number(new DataView(bytes).getBigUint64(0, true));
    const {arrays, content} = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 8, size)));
    return {...content, arrays: arrays.map(([kind, count, place]) => new (TYPES[kind] ?? Uint8Array)(bytes, 8 + size + place, count))};
  });
  const filled = (value, arrays) => {  // with the arrays that it names
    if (value === null || typeof value !== 'object') return value;
    for (const name of Object.keys(value)) value[name] = filled(value[name], arrays);
    return value.$ === undefined ? value : arrays[value.$];
  };
  const read = (file, arrays = file.arrays) => {
    file.whole ??= filled(file.values, arrays);
    return pairs => new Map(pairs.map(([place, k]) => [file.places[place].join('\n'), file.whole[k]]));
  };
  window.observerLabPacked = {load, read};
}
