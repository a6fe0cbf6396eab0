//! A cube with an edge crack, pulled open, sheared along and across the crack's front: Irwin's
//! modes (thesis Fig. 3.14).

use super::specimen::{Specimen, pieces};
use cullet_fracture::mpm::domain::VelocityFields;
use cullet_geometry::Vec3;

/// Half the edge of the cube, in spacings.
const HALF: f64 = 8.0;

/// What a cube came to.
struct Broken {
    /// Places of the points that broke, about the crack's front, in spacings.
    points: Vec<Vec3>,
    /// Pieces of more than a tenth of the body.
    pieces: usize,
}

/// Pulls the upper half along `way` and the lower half against it.
fn pull(way: Vec3) -> Broken {
    let specimen = Specimen::straight(HALF, 3);
    let mut domain = specimen.domain(way, VelocityFields::Split);
    while domain.steps < 700 {
        domain.advance();
    }
    Broken { points: specimen.broken(&domain.particles), pieces: pieces(&domain) }
}

#[test]
fn an_opened_crack_runs_on_in_its_plane() {
    let broken = pull(Vec3::new(0.0, 0.01, 0.0));
    assert_eq!(broken.pieces, 2);
    let far = broken.points.iter().filter(|x| x.y.abs() > 2.0).count() as f64;
    assert!(far < 0.05 * broken.points.len() as f64, "{far} of {}", broken.points.len());
    let mean = broken.points.iter().map(|x| x.y).sum::<f64>() / broken.points.len() as f64;
    assert!(mean.abs() < 0.5, "{mean}");
}

/// F08: what is pressed together does not crack.
#[test]
fn a_closed_crack_stays() {
    let broken = pull(Vec3::new(0.0, -0.01, 0.0));
    assert_eq!(broken.points.len(), 0);
    assert_eq!(broken.pieces, 1);
}

/// Sheared along the crack, it kinks towards the side that is pulled: most points near the front
/// break between 60 and 80 degrees; the greatest hoop stress is at 70.5 (K4).
#[test]
fn a_sheared_crack_kinks() {
    for sign in [1.0, -1.0] {
        let broken = pull(Vec3::new(0.01 * sign, 0.0, 0.0));
        let near = broken.points.iter().filter(|x| (1.0..5.0).contains(&x.xy().norm()));
        let mut sectors = [0; 18];
        for x in near {
            let angle = (-sign * x.y).atan2(x.x).to_degrees().rem_euclid(360.0);
            sectors[(angle / 20.0) as usize] += 1;
        }
        let most = (0..18).max_by_key(|&k| sectors[k]);
        assert_eq!(most, Some(3), "{sectors:?}");
    }
}

/// Sheared across, the front breaks ahead of itself, on both sides of the plane alike.
#[test]
fn a_torn_crack_goes_on_from_its_front() {
    let broken = pull(Vec3::new(0.0, 0.0, 0.01));
    let mean = broken.points.iter().map(|x| x.y).sum::<f64>() / broken.points.len() as f64;
    assert!(mean.abs() < 0.5, "{mean}");
    for slab in 0..7 {
        let slab = f64::from(slab)..f64::from(slab + 1);
        let count = broken.points.iter().filter(|x| slab.contains(&x.x) && x.y.abs() < 3.0).count();
        assert!(count > 30, "{count} in {slab:?}");
    }
}
