// Keeps the camera above the floor: it never looks from below what it looks at, and that never goes under the floor.
() => {
  const control = window.__viserMutable?.cameraControl;
  if (!control) return;
  const within = control._boundary.clone();
  within.min.set(-40, 0.1, -40);
  within.max.set(40, 40, 40);
  control.maxPolarAngle = Math.PI / 2;
  control.setBoundary(within);
}
