//! A solid whose surface was carried elsewhere.

use cullet_geometry::{Solid, Vec3};

/// A solid in its new shape, at the volume that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Reshaped {
    /// The solid.
    pub solid: Solid,
    /// By which share of the volume it was larger before it was made that \[1\].
    pub swollen: f64,
}

/// A solid whose vertices have gone to `places` \[m\], blown up or down about its centroid to a
/// `volume` \[m³\]; none where that turns it inside out.
#[must_use]
pub fn reshaped(mut solid: Solid, places: Vec<Vec3>, volume: f64) -> Option<Reshaped> {
    solid.mesh.vertices = places;
    let whole = solid.mesh.mass_properties();
    if whole.volume <= 0.0 {
        return None;
    }
    let (scale, centre) = (libm::cbrt(volume / whole.volume), whole.centroid);
    solid.mesh.vertices.iter_mut().for_each(|x| *x = centre + (*x - centre) * scale);
    Some(Reshaped { solid, swollen: whole.volume / volume - 1.0 })
}

#[cfg(test)]
mod tests {
    use super::reshaped;
    use cullet_geometry::{Solid, Vec3, shapes};

    #[test]
    fn a_shape_keeps_the_volume_and_is_not_turned_inside_out() {
        let mesh = shapes::cuboid(Vec3::new(1.0, 2.0, 3.0), shapes::Detail::default());
        let solid = Solid::outer(mesh.expect("a box"));
        let sheared = |x: &Vec3| Vec3::new(1.1 * x.x + 0.3 * x.z, x.y, x.z);
        let places: Vec<Vec3> = solid.mesh.vertices.iter().map(sheared).collect();
        let found = reshaped(solid.clone(), places, 6.0).expect("a shape");
        assert!((found.solid.mesh.signed_volume() - 6.0).abs() < 1e-12);
        assert!((found.swollen - 0.1).abs() < 1e-12, "{}", found.swollen);
        let mirrored = solid.mesh.vertices.iter().map(|x| Vec3::new(-x.x, x.y, x.z)).collect();
        assert_eq!(reshaped(solid, mirrored, 6.0), None);
    }
}
