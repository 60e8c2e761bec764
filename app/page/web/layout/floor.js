// Keeps the camera above the floor: it never looks from below what it looks at, and no hand takes that under the floor. Where a sheet
// lies over the stage we aim there ourselves, which stays.
() => {
  const control = window.__viserMutable?.cameraControl;
  if (!control) return;
  const within = control._boundary.clone();
  within.min.set(-40, 0.1, -40);
  within.max.set(40, 40, 40);
  control.maxPolarAngle = Math.PI / 2;
  const from = control.getPosition(), to = control.getTarget();
  control.setBoundary(within);  // takes what is looked at now over the floor
  control.setLookAt(from.x, from.y, from.z, to.x, to.y, to.z, false);
}
