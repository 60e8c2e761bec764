// Gives the nodes of a name their colour as it is, whatever light falls on them, once they stand in the scene.
({node, colour}) => {
  const viser = window.observerLabViser;
  let left = 120;  // frames in which the node may come, or another take the place of one of the same name
  const paint = () => {
    viser.node(node)?.traverse(part => {
      if (!part.material?.emissive || !part.material.toneMapped) return;
      part.material.color.set(0);
      part.material.emissive.set(colour);
      part.material.toneMapped = false;
      part.material.needsUpdate = true;
      part.material.depthWrite = false;
      part.renderOrder = 1;  // after the picture behind it, which shines through it
      viser.redraw();
    });
    if (left-- > 0) requestAnimationFrame(paint);
  };
  paint();
}
