//! Cubes of plaster that fall on their corners: whether they break does not depend on the number
//! of points.

use super::{Cullet, specimens, unique};

/// The largest piece of each of four cubes, over it, after the first hit at a speed \[m/s\].
fn largest(points: u32, speed: f64, seed: u32) -> Vec<f64> {
    let out = unique(&format!("cubes-{points}-{seed}"));
    let values = [
        format!("fracture.max_particles={points}"),
        format!("grid.cube.body.velocity=[0,0,{}]", -speed),
        format!("world.seed={seed}"),
        // They fall 5 cm, and have no second hit.
        format!("world.duration={}", 0.05 / speed + 0.004),
    ];
    let sets: Vec<&str> = values.iter().flat_map(|value| ["--set", value.as_str()]).collect();
    let run = Cullet::new(&["run", "-q", "--no-pictures"])
        .path(&specimens().join("scenes/cubes.toml"))
        .args(&[&sets[..], &["--out"]].concat())
        .path(&out)
        .output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    let masses = cullet_record::masses(&out.join("run.mcap")).expect("masses");
    std::fs::remove_dir_all(&out).ok();
    // One that stays whole has no pieces.
    let cubes = ["0-0-0", "1-0-0", "0-1-0", "1-1-0"].map(|cube| format!("cube-{cube}"));
    let of = |cube: &String| {
        let own = masses.iter().filter(|piece| piece.object == *cube);
        own.map(|piece| piece.ratio).reduce(f64::max).unwrap_or(1.0)
    };
    cubes.iter().map(of).collect()
}

/// From 4 m none stays whole, and the largest pieces of cubes of 2000, 4000 and 8000 points are as
/// large in the mean; from 0.3 m all do, but for crumbs.
#[test]
fn cubes_break_alike_with_few_points_and_with_many() {
    let means = [2000, 4000, 8000].map(|points| {
        let all: Vec<f64> = [1, 2].iter().flat_map(|&seed| largest(points, 9.0, seed)).collect();
        println!("{points} points: {all:.3?}");
        assert_eq!(all.len(), 8);
        assert!(all.iter().all(|&share| share < 0.9995), "{points} points: {all:?}");
        all.iter().sum::<f64>() / 8.0
    });
    assert!(means.iter().all(|mean| (0.4..=0.85).contains(mean)), "{means:?}");
    assert!(means.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 0.25), "{means:?}");
    for points in [2000, 8000] {
        let all = largest(points, 2.43, 1);
        assert!(all.iter().all(|&share| share >= 0.98), "{points} points: {all:?}");
    }
}
