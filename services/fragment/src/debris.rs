//! Fines: a part too small to be a fragment becomes grains that keep its mass and its motion.

use crate::pieces::direction;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::{Mat3, TriMesh, Vec3};
use cullet_model::Grain;

/// A point of the solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mote {
    /// Where it was before the hit \[m\].
    pub place: Vec3,
    /// Its velocity when the solve ended \[m/s\].
    pub velocity: Vec3,
}

/// The points of a solve that broke.
#[derive(Clone, Debug, Default)]
pub struct Motes {
    /// All of them.
    pub all: Vec<Mote>,
    /// Those less far than this from a part count as around it \[m\].
    pub reach: f64,
}

impl Motes {
    /// Those in the box around a part, and around that.
    #[must_use]
    pub fn around(&self, mesh: &TriMesh) -> Vec<Mote> {
        let (low, high) = mesh.bounds().unwrap_or_default();
        let reach = Vec3::repeat(self.reach);
        let (low, high) = (low - reach, high + reach);
        let near = |mote: &&Mote| (0..3).all(|k| (low[k]..=high[k]).contains(&mote.place[k]));
        self.all.iter().filter(near).copied().collect()
    }
}

/// A part that crumbles.
#[derive(Clone, Copy, Debug)]
pub struct CrumblingPart<'a> {
    /// Its closed boundary \[m\].
    pub mesh: &'a TriMesh,
    /// Velocity of its centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity \[rad/s\].
    pub spin: Vec3,
    /// Points of the solve in it and around it: each grain has the velocity of what it comes from.
    /// Without any, grains move as the part would.
    pub motes: &'a [Mote],
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

/// Places tried for each grain in the box around a part, before one is taken under its surface ...
const TRIES: u64 = 64;

/// ... out of so many, where it is thick rather than where it is thin.
const DEPTHS: u64 = 6;

/// Speed of a grain at random beside that of the nearest point of the solve, over how far the
/// speeds of the points differ \[1\]: a grid knows no motion within a cell.
const STRAY: f64 = 0.5;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xdeb1;

/// Turns a part into grains. `median` \[m\]: half the mass should be in larger grains; where
/// [`MOST`] grains cannot be so fine, they are as fine as they can be.
///
/// Mass and momentum are the part's up to rounding. Angular momentum is too where the grains can
/// carry it without more energy than the part had; what is left is returned. Beside the part's
/// motion they have no more energy than the points of the solve had beside theirs.
#[must_use]
pub fn grains(part: &CrumblingPart<'_>, median: f64, seed: u64) -> Fines {
    let whole = part.mesh.mass_properties();
    let volumes = volumes(whole.volume, median, seed);
    let mut places = places(part.mesh, whole.centroid, volumes.len(), seed);
    let own = drift(part.motes, &places, &whole.centroid, seed);
    let mean: Vec3 = places.iter().zip(&volumes).map(|(x, v)| x * *v).sum::<Vec3>() / whole.volume;
    places.iter_mut().for_each(|x| *x -= mean);
    let wanted = whole.inertia * part.spin;
    let inertia: Mat3 = places
        .iter()
        .zip(&volumes)
        .map(|(x, v)| (Mat3::identity() * x.norm_squared() - x * x.transpose()) * *v)
        .sum();
    let (spin, carried) = shared_spin(&inertia, &wanted, &part.spin);
    let own = balanced(own, &places, &volumes, &inertia, part.motes);
    let grain = |((x, volume), own): ((&Vec3, &f64), &Vec3)| Grain {
        position: whole.centroid + x,
        velocity: part.velocity + spin.cross(x) + own,
        volume: *volume,
        size: libm::cbrt(6.0 * volume / std::f64::consts::PI),
    };
    let grains = places.iter().zip(&volumes).zip(&own).map(grain).collect();
    Fines { grains, lost: wanted - carried }
}

/// How far velocities are from their mean: its square, in the mean \[m²/s²\].
fn variance(motes: &[Mote]) -> f64 {
    let share = 1.0 / motes.len().max(1) as f64;
    let mean = motes.iter().map(|mote| mote.velocity).sum::<Vec3>() * share;
    motes.iter().map(|mote| (mote.velocity - mean).norm_squared()).sum::<f64>() * share
}

/// The velocity of what is nearest to each place about the centroid, and a little at random.
fn drift(motes: &[Mote], places: &[Vec3], centroid: &Vec3, seed: u64) -> Vec<Vec3> {
    let stray = STRAY * variance(motes).sqrt();
    let own = |(k, x): (usize, &Vec3)| {
        let far = |mote: &&Mote| (mote.place - centroid - x).norm_squared();
        let nearest = motes.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let speed = stray * libm::cbrt(unit(seed, STREAM + 8, k as u64));
        let way = direction(seed ^ STREAM, k as u64);
        nearest.map_or_else(Vec3::zeros, |mote| mote.velocity + way * speed)
    };
    places.iter().enumerate().map(own).collect()
}

/// Velocities without momentum and, as far as points can, angular momentum, and with no more energy
/// than those of the solve.
fn balanced(
    mut own: Vec<Vec3>,
    places: &[Vec3],
    volumes: &[f64],
    inertia: &Mat3,
    motes: &[Mote],
) -> Vec<Vec3> {
    let whole: f64 = volumes.iter().sum();
    let mean = own.iter().zip(volumes).map(|(u, v)| u * *v).sum::<Vec3>() / whole;
    own.iter_mut().for_each(|u| *u -= mean);
    let turns = places.iter().zip(&own).zip(volumes);
    let angular: Vec3 = turns.map(|((x, u), v)| x.cross(u) * *v).sum();
    let (turn, _) = spin_of(inertia, &angular);
    own.iter_mut().zip(places).for_each(|(u, x)| *u -= turn.cross(x));
    let energy: f64 = own.iter().zip(volumes).map(|(u, v)| u.norm_squared() * v).sum();
    let limit = variance(motes) * whole;
    let factor = if energy > limit { (limit / energy).sqrt() } else { 1.0 };
    own.iter_mut().for_each(|u| *u *= factor);
    own
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
    let (inside, areas) = (Inside::new(mesh), areas(mesh));
    let (low, high) = inside.bounds();
    let place = |k: u64| {
        let tried = (0..TRIES).map(|t| {
            let draw = |axis: u64| unit(seed, STREAM + 1 + axis, k * TRIES + t);
            low + (high - low).component_mul(&Vec3::new(draw(0), draw(1), draw(2)))
        });
        let found = tried.into_iter().find(|x| inside.contains(*x));
        found.or_else(|| under(mesh, &areas, seed, k)).unwrap_or(centroid) - centroid
    };
    (0..count as u64).map(place).collect()
}

/// The areas of a mesh's triangles, each with those before it \[m²\].
fn areas(mesh: &TriMesh) -> Vec<f64> {
    let mut sum = 0.0;
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        sum += 0.5 * (b - a).cross(&(c - a)).norm();
        sum
    };
    (0..mesh.triangles.len()).map(area).collect()
}

/// A place under the surface of a part too thin to be met by chance: along the normal of some
/// place on it, and as likely there as it is deep.
fn under(mesh: &TriMesh, areas: &[f64], seed: u64, k: u64) -> Option<Vec3> {
    let whole = *areas.last()?;
    let depths = (0..DEPTHS).filter_map(|d| {
        let draw = |of: u64| unit(seed, STREAM + 4 + of, k * DEPTHS + d);
        let t = areas.partition_point(|&sum| sum < draw(0) * whole).min(areas.len() - 1);
        let [a, b, c] = mesh.corners(t);
        let way = (c - a).cross(&(b - a)).try_normalize(0.0)?;
        let root = draw(1).sqrt();
        let from = a + (b - a) * (root * (1.0 - draw(2))) + (c - a) * (root * draw(2));
        let others = (0..areas.len()).filter(|&other| other != t);
        let depth = others.filter_map(|other| met(&from, &way, mesh.corners(other)));
        let depth = depth.fold(f64::INFINITY, f64::min);
        depth.is_finite().then_some((from, way * depth, depth))
    });
    let depths: Vec<(Vec3, Vec3, f64)> = depths.collect();
    let all: f64 = depths.iter().map(|entry| entry.2).sum();
    let mut left = all * unit(seed, STREAM + 7, 2 * k);
    let taken = depths.iter().find(|entry| {
        left -= entry.2;
        left <= 0.0
    });
    taken.map(|(from, way, _)| from + way * unit(seed, STREAM + 7, 2 * k + 1))
}

/// How far along a unit vector a triangle is met, if ahead (Möller and Trumbore, 1997) \[m\].
fn met(from: &Vec3, way: &Vec3, [a, b, c]: [Vec3; 3]) -> Option<f64> {
    let (one, two) = (b - a, c - a);
    let across = way.cross(&two);
    let turn = one.dot(&across);
    if turn == 0.0 {
        return None;
    }
    let arm = from - a;
    let u = arm.dot(&across) / turn;
    let up = arm.cross(&one);
    let v = way.dot(&up) / turn;
    let far = two.dot(&up) / turn;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && far > 0.0).then_some(far)
}

/// The spin that gives points of that inertia the angular momentum, as far as they can have it, and
/// how much of it that is.
fn spin_of(inertia: &Mat3, wanted: &Vec3) -> (Vec3, Vec3) {
    let axes = inertia.symmetric_eigen();
    let least = LINE * axes.eigenvalues.amax();
    let (mut own, mut carried) = (Vec3::zeros(), Vec3::zeros());
    for k in (0..3).filter(|&k| axes.eigenvalues[k] > least) {
        let axis: Vec3 = axes.eigenvectors.column(k).into();
        let along = axis.dot(wanted);
        own += axis * (along / axes.eigenvalues[k]);
        carried += axis * along;
    }
    (own, carried)
}

/// As [`spin_of`], slowed until it has no more energy than the part's.
fn shared_spin(inertia: &Mat3, wanted: &Vec3, spin: &Vec3) -> (Vec3, Vec3) {
    let (own, carried) = spin_of(inertia, wanted);
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

    /// Points of a solve in a mesh, that fly apart.
    fn around(mesh: &TriMesh, seed: u64) -> Vec<Mote> {
        let centre = mesh.mass_properties().centroid;
        let places = places(mesh, centre, 30, seed ^ 0x77);
        let mote = |x: &Vec3| Mote { place: centre + x, velocity: x * 200.0 + Vec3::y() };
        places.iter().map(mote).collect()
    }

    #[test]
    fn mass_and_momentum_are_the_parts_and_energy_is_no_more() {
        let mesh = block();
        let whole = mesh.mass_properties();
        let (velocity, spin) = (Vec3::new(3.0, -1.0, 2.0), Vec3::new(40.0, 10.0, -90.0));
        for seed in 0..40 {
            let median = 0.001 + 0.001 * seed as f64;
            let motes = around(&mesh, seed);
            let fines =
                grains(&CrumblingPart { mesh: &mesh, velocity, spin, motes: &motes }, median, seed);
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
            // Rigid motion and what is beside it have no energy in common.
            let before = before + variance(&motes) * whole.volume;
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
        let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
        let rest = CrumblingPart { mesh: &mesh, velocity, spin, motes: &[] };
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
        let part = CrumblingPart { mesh: &mesh, velocity: Vec3::x(), spin: Vec3::z(), motes: &[] };
        assert_eq!(grains(&part, 0.003, 5), grains(&part, 0.003, 5));
        assert_ne!(grains(&part, 0.003, 5), grains(&part, 0.003, 6));
        // One grain spins about nothing: all of it is returned.
        let lost = grains(&part, 1.0, 5).lost;
        assert!((lost - mesh.mass_properties().inertia * Vec3::z()).norm() < 1e-18);
    }

    /// Grains of a part that flies apart do so too: no two of them keep their distance.
    #[test]
    fn grains_spread_as_the_points_around_them_do() {
        let mesh = block();
        let (motes, velocity, spin) = (around(&mesh, 3), Vec3::x() * 5.0, Vec3::zeros());
        let some = |motes: &[Mote]| {
            grains(&CrumblingPart { mesh: &mesh, velocity, spin, motes }, 0.009, 3).grains
        };
        let (spread, rigid) = (some(&motes), some(&[]));
        let apart = |all: &[Grain]| {
            let pairs =
                all.iter().enumerate().flat_map(|(k, a)| all[..k].iter().map(move |b| (a, b)));
            pairs.map(|(a, b)| (a.velocity - b.velocity).norm()).fold(f64::INFINITY, f64::min)
        };
        assert_eq!(apart(&rigid), 0.0);
        assert!(apart(&spread) > 1e-3, "{}", apart(&spread));
        let centre = mesh.mass_properties().centroid;
        let out =
            spread.iter().map(|g| (g.velocity - velocity).dot(&(g.position - centre)) * g.volume);
        assert!(out.sum::<f64>() > 0.0);
    }

    /// In a slab as thin as a kerf, whose box it hardly fills, grains lie everywhere and not on
    /// one another.
    #[test]
    fn grains_of_a_thin_part_fill_it() {
        let size = Vec3::new(0.03, 0.03, 2e-5);
        let flat = shapes::cuboid(size, shapes::Detail::default()).expect("a slab");
        let turn = cullet_geometry::Quat::from_euler_angles(0.7, 0.5, 0.3);
        let back = |x: &Vec3| turn.inverse() * x;
        let mut mesh = flat;
        mesh.vertices.iter_mut().for_each(|x| *x = turn * *x);
        let part =
            CrumblingPart { mesh: &mesh, velocity: Vec3::x(), spin: Vec3::zeros(), motes: &[] };
        let all = grains(&part, 1e-4, 4).grains;
        assert_eq!(all.len(), MOST);
        let at: Vec<Vec3> = all.iter().map(|g| back(&g.position)).collect();
        for quarter in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let there = at.iter().filter(|x| x.x * quarter[0] > 0.0 && x.y * quarter[1] > 0.0);
            assert!((8..=24).contains(&there.count()));
        }
        let mut pairs =
            at.iter().enumerate().flat_map(|(k, a)| at[..k].iter().map(move |b| (a, b)));
        assert!(pairs.all(|(a, b)| (a - b).norm() > 1e-5));
        assert!(at.iter().all(|x| x.z.abs() < 1e-3));
    }
}
