// Keeps the camera above the floor: it never looks from below what it looks at, and no hand takes that under the floor. Where a sheet
// lies over the stage we aim there ourselves, which stays.
() => {
  window.observerLabViser.keepCamera({low: [-40, 0.1, -40], high: [40, 40, 40], steepest: Math.PI / 2});
}
