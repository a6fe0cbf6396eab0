//! Fines: a part too small to be a fragment becomes grains that keep its mass and its motion.

use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::{Mat3, TriMesh, Vec3};

/// One grain, in the body's frame before it broke: a point with a mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Where \[m\].
    pub position: Vec3,
    /// Velocity that the hit gave it, beside the body's motion before the hit \[m/s\].
    pub velocity: Vec3,
    /// Volume \[m³\].
    pub volume: f64,
    /// Diameter of the ball of that volume \[m\].
    pub size: f64,
}

/// A part that crumbles.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Its closed boundary \[m\].
    pub mesh: &'a TriMesh,
    /// Velocity of its centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity \[rad/s\].
    pub spin: Vec3,
}

/// What becomes of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Fines {
    /// At most [`MOST`], from large to small.
    pub grains: Vec<Grain>,
    /// Angular momentum about the part's centroid that points cannot carry without a gain of
    /// energy, over the density \[m⁵/s\].
    pub lost: Vec3,
}

/// Most grains of one part.
pub const MOST: usize = 64;

/// Exponent D of the sizes, N(>d) ∝ d^−D: 2.5 is usual for crushed rock, and n(m) ∝ m^−1.83 (G2).
pub const EXPONENT: f64 = 2.5;

/// How far a rank is moved at random: less than half, so that sizes stay in order.
const JITTER: f64 = 0.45;

/// Halvings of the largest sizes that are tried.
const CUTS: u32 = 10;

/// Inertia about an axis, over the greatest, below which points lie on that axis \[1\].
const LINE: f64 = 1e-6;

/// Places tried for each grain before it is put at the centroid.
const TRIES: u64 = 64;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xdeb1;

/// Turns a part into grains. `median` \[m\]: half the mass should be in larger grains; where
/// [`MOST`] grains cannot be so fine, they are as fine as they can be.
///
/// Mass and momentum are the part's up to rounding. Angular momentum is too where the grains can
/// carry it without more energy than the part had; what is left is told.
#[must_use]
pub fn grains(part: &Part<'_>, median: f64, seed: u64) -> Fines {
    let whole = part.mesh.mass_properties();
    let volumes = volumes(whole.volume, median, seed);
    let mut places = places(part.mesh, whole.centroid, volumes.len(), seed);
    let mean: Vec3 = places.iter().zip(&volumes).map(|(x, v)| x * *v).sum::<Vec3>() / whole.volume;
    places.iter_mut().for_each(|x| *x -= mean);
    let wanted = whole.inertia * part.spin;
    let inertia: Mat3 = places
        .iter()
        .zip(&volumes)
        .map(|(x, v)| (Mat3::identity() * x.norm_squared() - x * x.transpose()) * *v)
        .sum();
    let (spin, carried) = shared_spin(&inertia, &wanted, &part.spin);
    let grain = |(x, volume): (&Vec3, &f64)| Grain {
        position: whole.centroid + x,
        velocity: part.velocity + spin.cross(x),
        volume: *volume,
        size: libm::cbrt(6.0 * volume / std::f64::consts::PI),
    };
    let grains = places.iter().zip(&volumes).map(grain).collect();
    Fines { grains, lost: wanted - carried }
}

/// Volumes of the fewest grains that are fine enough, in all `whole`: d_k ∝ (k + s)^(−1/D) for the
/// rank k. The cut s of the largest sizes is zero unless [`MOST`] grains of the whole law are too
/// coarse.
fn volumes(whole: f64, median: f64, seed: u64) -> Vec<f64> {
    let law = |count: usize, cut: f64| -> Vec<f64> {
        let share = |k: usize| {
            let shift = JITTER * (2.0 * unit(seed, STREAM, k as u64) - 1.0);
            libm::pow(k as f64 + 1.0 + shift + cut, -3.0 / EXPONENT)
        };
        let shares: Vec<f64> = (0..count).map(share).collect();
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share / sum * whole).collect()
    };
    let wanted = std::f64::consts::PI / 6.0 * median * median * median;
    let fine = |volumes: &Vec<f64>| {
        let mut above = 0.0;
        let middle = volumes.iter().find(|&&volume| {
            above += volume;
            above >= 0.5 * whole
        });
        middle.is_none_or(|volume| *volume <= wanted)
    };
    let counts = (1..=MOST).map(|count| law(count, 0.0));
    let cuts = (0..CUTS).map(|k| law(MOST, libm::exp2(f64::from(k))));
    counts.chain(cuts).find(fine).unwrap_or_else(|| vec![whole / MOST as f64; MOST])
}

/// Places within the part, about its centroid \[m\].
fn places(mesh: &TriMesh, centroid: Vec3, count: usize, seed: u64) -> Vec<Vec3> {
    if count < 2 {
        return vec![Vec3::zeros(); count];
    }
    let inside = Inside::new(mesh);
    let (low, high) = inside.bounds();
    let place = |k: u64| {
        let tried = (0..TRIES).map(|t| {
            let draw = |axis: u64| unit(seed, STREAM + 1 + axis, k * TRIES + t);
            low + (high - low).component_mul(&Vec3::new(draw(0), draw(1), draw(2)))
        });
        tried.into_iter().find(|x| inside.contains(*x)).map_or_else(Vec3::zeros, |x| x - centroid)
    };
    (0..count as u64).map(place).collect()
}

/// The spin that gives points of that inertia the angular momentum, slowed until it has no more
/// energy than the part's; and what angular momentum that is.
fn shared_spin(inertia: &Mat3, wanted: &Vec3, spin: &Vec3) -> (Vec3, Vec3) {
    let axes = inertia.symmetric_eigen();
    let least = LINE * axes.eigenvalues.amax();
    let (mut own, mut carried) = (Vec3::zeros(), Vec3::zeros());
    for k in (0..3).filter(|&k| axes.eigenvalues[k] > least) {
        let axis: Vec3 = axes.eigenvectors.column(k).into();
        let along = axis.dot(wanted);
        own += axis * (along / axes.eigenvalues[k]);
        carried += axis * along;
    }
    let (energy, limit) = (own.dot(&carried), spin.dot(wanted));
    let factor = if energy > limit { (limit / energy).max(0.0).sqrt() } else { 1.0 };
    (own * factor, carried * factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::shapes;

    fn block() -> TriMesh {
        let size = Vec3::new(0.03, 0.02, 0.01);
        let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
        mesh.translated(Vec3::new(0.4, -0.2, 0.1))
    }

    #[test]
    fn mass_and_momentum_are_the_parts_and_energy_is_no_more() {
        let mesh = block();
        let whole = mesh.mass_properties();
        let (velocity, spin) = (Vec3::new(3.0, -1.0, 2.0), Vec3::new(40.0, 10.0, -90.0));
        for seed in 0..40 {
            let median = 0.001 + 0.001 * seed as f64;
            let fines = grains(&Part { mesh: &mesh, velocity, spin }, median, seed);
            let grains = &fines.grains;
            let volume: f64 = grains.iter().map(|g| g.volume).sum();
            assert!((volume / whole.volume - 1.0).abs() < 1e-13);
            let momentum: Vec3 = grains.iter().map(|g| g.velocity * g.volume).sum();
            assert!((momentum / whole.volume - velocity).norm() < 1e-12 * velocity.norm());
            let centre = |g: &Grain| g.position - whole.centroid;
            let angular: Vec3 =
                grains.iter().map(|g| centre(g).cross(&g.velocity) * g.volume).sum();
            let wanted = whole.inertia * spin;
            assert!((angular + fines.lost - wanted).norm() < 1e-9 * wanted.norm(), "seed {seed}");
            let energy: f64 = grains.iter().map(|g| g.velocity.norm_squared() * g.volume).sum();
            let before = velocity.norm_squared() * whole.volume + spin.dot(&wanted);
            assert!(energy <= before * (1.0 + 1e-12), "seed {seed}: {energy} of {before}");
            assert!(grains.is_sorted_by(|a, b| a.size >= b.size) && grains.len() <= MOST);
            let (low, high) = mesh.bounds().expect("bounds");
            let slack = Vec3::repeat(0.02);
            let near = |g: &Grain| g.position > low - slack && g.position < high + slack;
            assert!(grains.iter().all(near));
        }
    }

    #[test]
    fn sizes_follow_the_power_law_and_the_median() {
        let mesh = block();
        let rest = Part { mesh: &mesh, velocity: Vec3::zeros(), spin: Vec3::zeros() };
        let fine = grains(&rest, 0.0095, 1).grains;
        assert!(fine.len() > 50, "{}", fine.len());
        // The slope of log rank over log size, by least squares, is −D.
        let points: Vec<(f64, f64)> = fine
            .iter()
            .enumerate()
            .skip(3)
            .map(|(k, g)| (libm::log(g.size), libm::log(k as f64 + 1.0)))
            .collect();
        let n = points.len() as f64;
        let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
        let top: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
        let slope = top / points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum::<f64>();
        assert!((slope + EXPONENT).abs() < 0.2, "slope {slope}");
        for median in [0.006, 0.007, 0.009, 0.014] {
            let some = grains(&rest, median, 2).grains;
            let half = some.iter().map(|g| g.volume).sum::<f64>() / 2.0;
            let mut above = 0.0;
            let middle = some.iter().find(|g| {
                above += g.volume;
                above >= half
            });
            let size = middle.expect("a middle").size;
            assert!(size <= median && size > 0.7 * median, "{size} for {median}");
        }
        let finest = grains(&rest, 1e-4, 1).grains;
        assert!(finest[0].size < 1.01 * finest[MOST - 1].size, "as fine as so many can be");
        assert_eq!(grains(&rest, 1.0, 3).grains.len(), 1, "a coarse grain is the part itself");
    }

    #[test]
    fn equal_seeds_give_equal_grains() {
        let mesh = block();
        let part = Part { mesh: &mesh, velocity: Vec3::x(), spin: Vec3::z() };
        assert_eq!(grains(&part, 0.003, 5), grains(&part, 0.003, 5));
        assert_ne!(grains(&part, 0.003, 5), grains(&part, 0.003, 6));
        // One grain spins about nothing: all of it is told.
        let lost = grains(&part, 1.0, 5).lost;
        assert!((lost - mesh.mass_properties().inertia * Vec3::z()).norm() < 1e-18);
    }
}
