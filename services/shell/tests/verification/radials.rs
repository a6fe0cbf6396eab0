//! D9: how many radial cracks a pane gets, by the speed of what hits it.

use crate::pane::{adds_up, pane, solve};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_model::{Fragmentation, Settings};

/// Cracks that cross a circle of the radius `radius` about the middle, in the middle of the
/// thickness.
fn crossings(found: &Fragmentation, radius: f64) -> usize {
    let parts: Vec<Inside> = found.fragments.iter().map(|f| Inside::new(&f.solid.mesh)).collect();
    let part = |k: usize| {
        let angle = k as f64 / 720.0 * std::f64::consts::TAU;
        let place = Vec3::new(angle.cos(), angle.sin(), 0.0) * radius;
        parts.iter().position(|part| part.contains(place))
    };
    let around: Vec<usize> = (0..720).filter_map(part).collect();
    (0..around.len()).filter(|&k| around[k] != around[(k + 1) % around.len()]).count()
}

/// D9: n ∝ √V in experiments \[Vandenberghe, Vermorel & Villermaux 2013\]. Held to a star at every
/// speed; the exponent is printed, and stated in the catalogue.
#[test]
fn d9_radial_cracks_by_speed() {
    let mut rows = Vec::new();
    for speed in [2.5_f64, 5.0, 10.0, 20.0] {
        let settings = Settings { spacing: Some(4e-3), ..Settings::default() };
        let problem = pane([0.3, 0.3, 0.008], 0.025, speed, settings);
        let found = solve(problem.clone());
        adds_up(&problem, &found);
        let count = [0.08, 0.1, 0.12].map(|radius| crossings(&found, radius));
        let mean = count.iter().sum::<usize>() as f64 / 3.0;
        println!("D9: {speed} m/s: {count:?} cracks at 8, 10 and 12 cm");
        assert!(count.iter().all(|&n| n >= 3), "{speed} m/s: {count:?}");
        rows.push((speed.ln(), mean.ln()));
    }
    let n = rows.len() as f64;
    let (x, y) =
        (rows.iter().map(|r| r.0).sum::<f64>() / n, rows.iter().map(|r| r.1).sum::<f64>() / n);
    let slope = rows.iter().map(|r| (r.0 - x) * (r.1 - y)).sum::<f64>()
        / rows.iter().map(|r| (r.0 - x).powi(2)).sum::<f64>();
    println!("D9: n goes with the speed to the power {slope:.2}");
}
