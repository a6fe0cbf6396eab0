//! Crushed zones of bars and blocks.

use super::sizes::Mott;
use super::{CrushRules, KernelLattice, LEAST_SIZE, divide, pieces};
use crate::particles::Particles;
use cullet_fragment::pieces::{Ball, Pieces};
use cullet_geometry::Vec3;
use cullet_model::{Material, Tolerance};

/// Fragments are finer than a cell at any rate.
const CHALK: Material = Material {
    density: 1000.0,
    young: 1e9,
    poisson: 0.2,
    failure_stress: 1e6,
    fracture_energy: 1.0,
};
const RULES: CrushRules = CrushRules {
    spacing: Vec3::new(1.0, 1.0, 1.0),
    material: CHALK,
    seed: 5,
    tolerance: Tolerance(None),
    most: 4000,
    push: Vec3::new(1.0, 0.0, 0.0),
};

/// A bar of 20 × 6 × 6 cells, eight points a cell; `piece` says what a point belongs to.
fn bar(piece: impl Fn(&Vec3) -> Option<u32>) -> (Vec<Vec3>, Pieces) {
    asked_of_bar(None, piece)
}

/// Where an error is good enough.
fn asked_of_bar(error: Option<f64>, piece: impl Fn(&Vec3) -> Option<u32>) -> (Vec<Vec3>, Pieces) {
    let point = |i: usize| {
        let at = Vec3::new((i / 144) as f64, (i / 12 % 12) as f64, (i % 12) as f64);
        (at + Vec3::repeat(0.5)) * 0.5 - Vec3::new(10.0, 3.0, 3.0)
    };
    let points: Vec<Vec3> = (0..40 * 144).map(point).collect();
    let mut particles = Particles::at_rest(&points, 720.0, 1.0);
    particles.onset_rate.fill(10.0);
    let rules = CrushRules { tolerance: Tolerance(error), ..RULES };
    let found = pieces(&particles, points.iter().map(&piece).collect(), &rules);
    (points, found)
}

#[test]
fn the_band_of_a_crack_is_not_a_crushed_zone() {
    let sides = |x: &Vec3| (x.x.abs() > 1.6).then(|| u32::from(x.x > 0.0));
    let (points, found) = bar(sides);
    assert_eq!((found.rubble.balls.len(), found.crushed), (0, 0.0));
    assert!(points.iter().zip(&found.of).all(|(x, piece)| *piece == sides(x)));
}

#[test]
fn crumbs_are_no_pieces() {
    let crumb = |x: &Vec3| Some(u32::from((x - Vec3::repeat(0.5)).amax() < 0.6));
    let (_, found) = bar(|x| crumb(x).filter(|&p| p == 0 || x.z > 0.4));
    assert!(found.of.iter().flatten().all(|&piece| piece == 0));
}

#[test]
fn a_crushed_end_is_divided() {
    let (points, found) = bar(|x| (x.x > 0.0).then_some(0));
    assert!(found.rubble.balls.len() > 4, "{found:?}");
    assert!((found.crushed - 0.42).abs() < 0.15, "{}", found.crushed);
    for (x, piece) in points.iter().zip(&found.of) {
        match piece {
            Some(0) => assert!(x.x > 0.0),
            Some(_) => assert!(x.x < -1.0, "{x}"),
            None => assert!((-3.5..0.0).contains(&x.x), "{x}"),
        }
    }
    assert_eq!(found, bar(|x| (x.x > 0.0).then_some(0)).1);
}

#[test]
fn a_body_that_is_crushed_whole_is_divided_whole() {
    let (_, found) = bar(|_| None);
    assert!(found.rubble.balls.len() > 10 && found.of.iter().all(Option::is_some));
    assert_eq!(found.crushed, 1.0);
}

/// G2: Mott's law has a share of 1 − e^(−√2) of its pieces below the mean mass, and half of
/// all mass in the heaviest 1 − (1 + x + x²/2) e^(−x) = ½ at x = √(m/μ) = 2.674.
#[test]
fn drawn_sizes_follow_mott() {
    let masses = Mott::new(0.0, f64::INFINITY).volumes(40_000, 3);
    let mean = masses.iter().sum::<f64>() / masses.len() as f64;
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
    let below = masses.iter().filter(|&&m| m < 1.0).count() as f64 / masses.len() as f64;
    assert!((below - 0.7569).abs() < 0.01, "{below}");
    let half = 0.5 * 2.674 * 2.674;
    let heavy: f64 = masses.iter().filter(|&&m| m > half).sum();
    assert!((heavy / masses.iter().sum::<f64>() - 0.5).abs() < 0.02, "{heavy}");
}

/// From a least mass on the law is the same, √m − √m₀ exponential, and the mean is kept.
#[test]
fn a_least_mass_keeps_the_law_and_the_mean() {
    for least in [0.02, 0.1, 0.5] {
        let masses = Mott::new(least, f64::INFINITY).volumes(40_000, 3);
        let mean = masses.iter().sum::<f64>() / masses.len() as f64;
        assert!((mean - 1.0).abs() < 0.03, "{mean}");
        assert!(masses.iter().all(|&m| m >= least));
        let roots: Vec<f64> = masses.iter().map(|m| m.sqrt() - least.sqrt()).collect();
        let mean = roots.iter().sum::<f64>() / roots.len() as f64;
        let below = |x: f64| roots.iter().filter(|&&r| r < x * mean).count() as f64;
        for x in [0.1, 0.5, 1.0, 2.0, 4.0] {
            let share = below(x) / roots.len() as f64;
            assert!((share - 1.0 + libm::exp(-x)).abs() < 0.01, "{share} below {x}");
        }
    }
}

/// Below a greatest mass the law is the same, and its mean is what it says.
#[test]
fn a_greatest_mass_keeps_the_law() {
    for (least, most) in [(0.0, 4.0), (0.03, 4.2), (0.03, 1.5)] {
        let law = Mott::new(least, most);
        let all = Mott::new(least, f64::INFINITY).volumes(40_000, 3);
        let held: Vec<f64> = all.into_iter().filter(|&m| m <= most).collect();
        let cut = law.volumes(held.len(), 3);
        assert!(cut.iter().all(|&m| m <= most * (1.0 + 1e-12)));
        let mean = cut.iter().sum::<f64>() / cut.len() as f64;
        assert!((mean / law.mean() - 1.0).abs() < 0.01, "{mean}, {}", law.mean());
        for part in [10, 4, 2] {
            let [held, cut] = [&held, &cut].map(|masses| masses[masses.len() / part]);
            assert!((held / cut - 1.0).abs() < 0.02, "{held} and {cut} at 1/{part}");
        }
    }
}

/// Where fewer pieces are wanted than the rate asks for they are larger, not of one size: the
/// greatest of a tenth of them has over thirty times the mass of the least of another.
#[test]
fn few_pieces_keep_the_whole_range() {
    let point = |i: usize| Vec3::from([i / 1600, i / 40 % 40, i % 40].map(|k| 0.5 * k as f64));
    let points: Vec<Vec3> = (0..40 * 1600).map(point).collect();
    let mut particles = Particles::at_rest(&points, 8000.0, 1.0);
    particles.onset_rate.fill(10.0);
    let of = |most: u32| {
        let rules = CrushRules { most, ..RULES };
        let found = pieces(&particles, vec![None; points.len()], &rules);
        let mut masses = vec![0.0; found.rubble.balls.len()];
        found.of.iter().flatten().for_each(|&piece| masses[piece as usize] += 1.0);
        masses.sort_unstable_by(f64::total_cmp);
        masses
    };
    let masses = of(400);
    let count = masses.len();
    assert!((250..=360).contains(&count), "{count}");
    let ratio = masses[count * 9 / 10] / masses[count / 10];
    println!("{count} pieces, the ninth tenth over the first {ratio:.1}");
    assert!(ratio > 30.0, "{ratio}");
    let all = of(4000);
    let ratio = all[all.len() * 9 / 10] / all[all.len() / 10];
    println!("{} pieces, {ratio:.1}", all.len());
    assert!(ratio > 25.0 && 6 * all.len() > 7 * count, "{ratio}, {}", all.len());
}

/// Pieces sampled in a crushed zone are of many sizes, as those of real rubble are.
#[test]
fn drawn_pieces_are_large_and_small() {
    let (_, found) = bar(|_| None);
    let mut points = vec![0.0; found.rubble.balls.len()];
    found.of.iter().flatten().for_each(|&piece| points[piece as usize] += 1.0);
    let mean = points.iter().sum::<f64>() / points.len() as f64;
    let variance = points.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / points.len() as f64;
    assert!(variance.sqrt() > 0.6 * mean, "{} around {mean}", variance.sqrt());
    let empty = points.iter().filter(|&&n| n == 0.0).count();
    assert!(empty * 25 < points.len(), "{empty} of {} without a point", points.len());
}

/// An error buys fewer and larger pieces, as many lattice nodes across: 1.6³ in the mean.
#[test]
fn an_error_draws_larger_pieces() {
    let drawn = |error| asked_of_bar(error, |_| None).1.rubble.balls;
    let (fine, coarse) = (drawn(None), drawn(Some(0.5)));
    assert_eq!(drawn(Some(1.0)), coarse);
    let ratio = fine.len() as f64 / coarse.len() as f64;
    assert!((3.0..5.5).contains(&ratio), "{} and {}", fine.len(), coarse.len());
    let least = |balls: &[Ball]| balls.iter().map(|b| b.size).fold(f64::INFINITY, f64::min);
    let full = libm::cbrt(0.65);
    let (fine, coarse) = (least(&fine) / full, least(&coarse) / full / 1.6);
    assert!((0.999..1.3).contains(&(fine / LEAST_SIZE)), "{fine}");
    assert!((0.999..1.3).contains(&(coarse / LEAST_SIZE)), "{coarse}");
}

/// The pieces are those of all sites, though each looks at the nodes around it only.
#[test]
fn every_node_goes_to_the_nearest_of_all_sites() {
    let points: Vec<Vec3> = (0..30 * 30 * 30)
        .map(|i| Vec3::new((i / 900) as f64, (i / 30 % 30) as f64, (i % 30) as f64) * 0.5)
        .collect();
    let mut particles = Particles::at_rest(&points, 3375.0, 1.0);
    // One corner asks for pieces of many cells.
    for (rate, x) in particles.onset_rate.iter_mut().zip(&points) {
        *rate = if x.amax() < 5.0 { 1e-2 } else { 10.0 };
    }
    let lattice = KernelLattice::new(&points, RULES.spacing);
    let (weights, zone) = (vec![8.0; lattice.len()], (0..lattice.len()).collect::<Vec<_>>());
    let mut labels = vec![None; lattice.len()];
    let sites = divide(&lattice, &mut labels, &zone, &weights, &particles, &RULES, 4000.0);
    assert!(sites.len() > 100 && sites[0].size > 2.0 * sites[sites.len() / 2].size);
    for (n, label) in labels.iter().enumerate() {
        let x = lattice.place(n, RULES.seed);
        let far = |site: u32| sites[site as usize].far(&x);
        let nearest = (0..sites.len() as u32).min_by(|&a, &b| far(a).total_cmp(&far(b)));
        assert_eq!(*label, nearest);
    }
    for (k, one) in sites.iter().enumerate() {
        for two in &sites[..k] {
            let room = (one.place - two.place).norm() - 0.5 * (one.size + two.size);
            assert!(room > -1e-9, "two balls overlap by {}", -room);
        }
    }
}
