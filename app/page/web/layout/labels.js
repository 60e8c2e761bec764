// Writes the labels of the stage in an ink on a ground of the theme; viser knows black on white alone.
({ink, ground}) => {
  const page = window.__viserMutable, lab = window.observerLabLabels ??= {Ink: {value: []}, Ground: {value: []}};
  const parts = colour => [1, 3, 5].map(i => parseInt(colour.slice(i, i + 2), 16) / 255);
  lab.Ink.value = parts(ink);
  lab.Ground.value = parts(ground);
  const dress = ({material: skin}) => {
    if (!skin?.fragmentShader?.includes('vAlpha')) return false;
    for (const [written, name] of [['vec4(0.0, 0.0, 0.0,', 'Ink'], ['vec4(1.0, 1.0, 1.0,', 'Ground']]) {
      if (!skin.fragmentShader.includes(`gl_FragColor = ${written}`)) continue;
      skin.uniforms[`observerLab${name}`] = lab[name];
      skin.fragmentShader = `uniform vec3 observerLab${name};\n${skin.fragmentShader.replace(written, `vec4(observerLab${name},`)}`;
      skin.needsUpdate = true;
    }
    return true;
  };
  page?.scene?.traverse(part => {
    if (!dress(part) || lab.room === part.parent) return;
    lab.room = part.parent;  // where viser puts one more mesh for each size of letters
    lab.room.addEventListener('childadded', ({child}) => dress(child));
  });
  page?.requestRender?.();
}
