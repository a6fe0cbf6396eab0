//! The motion of fragments that carries what was given to the body.

use cullet_geometry::{Mat3, Vec3};
use cullet_model::Fragment;

/// Makes fragments carry exactly the momentum and the angular momentum of `pushes`: points \[m\]
/// and impulses \[N·s\].
///
/// A fragment's mesh holds a little more or less mass than its points, and its velocity was taken
/// where it had come to, not where it was before the hit: one rigid motion of all makes up for
/// both.
pub fn balance(fragments: &mut [Fragment], pushes: &[(Vec3, Vec3)], density: f64) {
    let sum = pushes.iter().map(|(_, impulse)| impulse).sum();
    let about =
        |centre: Vec3| pushes.iter().map(|(point, impulse)| (point - centre).cross(impulse)).sum();
    carry(fragments, sum, about, density);
}

/// Makes fragments carry exactly a momentum \[kg·m/s\] and the angular momentum that `about` gives
/// of their common centre \[kg·m²/s\].
pub fn carry(
    fragments: &mut [Fragment],
    momentum: Vec3,
    about: impl FnOnce(Vec3) -> Vec3,
    density: f64,
) {
    let own: Vec<_> = fragments.iter().map(|f| f.solid.mesh.mass_properties()).collect();
    let volume: f64 = own.iter().map(|p| p.volume).sum();
    let centre = own.iter().map(|p| p.centroid * p.volume).sum::<Vec3>() / volume;
    let (mut linear, mut angular) = (momentum / density, about(centre) / density);
    let mut inertia = Mat3::zeros();
    for (fragment, p) in fragments.iter().zip(&own) {
        let r = p.centroid - centre;
        linear -= fragment.velocity * p.volume;
        angular -= r.cross(&fragment.velocity) * p.volume + p.inertia * fragment.spin;
        let square = Mat3::identity() * r.norm_squared() - r * r.transpose();
        inertia += p.inertia + square * p.volume;
    }
    let shift = linear / volume;
    let turn = inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * angular);
    for (fragment, p) in fragments.iter_mut().zip(&own) {
        fragment.velocity += shift + turn.cross(&(p.centroid - centre));
        fragment.spin += turn;
    }
}
