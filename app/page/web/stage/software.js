// Runs before viser's page: without a graphics card the view is drawn without multisampling, which doubles the price of a
// frame there.
() => {
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe) return;
  const named = probe.getExtension('WEBGL_debug_renderer_info');
  const drawer = probe.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : probe.RENDERER);
  probe.getExtension('WEBGL_lose_context')?.loseContext();
  if (!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(drawer)) return;
  window.observerLabNoCard = true;
  const open = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, how) {
    return open.call(this, kind, String(kind).startsWith('webgl') ? {...how, antialias: false} : how);
  };
}
