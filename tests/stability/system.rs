//! Threads, numbers, units and chance: F75 to F78.

use crate::kit::{H, PLASTER, STRONG, blow, body, cuboid, problem, rows, solved};
use cullet_document::files::{Bundle, SceneFile};
use cullet_fracture::mpm::diagnostics::Diagnostics;
use cullet_geometry::{Vec3, math::unit};
use cullet_lab::frontier;
use cullet_lab::frontier::stats::ensemble;
use cullet_model::{BrittleProblem, Failure};
use cullet_scene::load_bundle;
use std::sync::Arc;

/// Does something on so many threads.
fn on<T: Send>(threads: usize, run: impl Fn() -> T + Send + Sync) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(run)
}

/// F75: the same bits on one, two, three and seven threads: of a shattering block's motion, damage
/// and of all that its steps add up, which another order of the same numbers would change; and of
/// a solve from problem to fragments.
#[test]
fn f75_threads_do_not_change_a_bit() {
    let shatter = || {
        let mut domain = body(&rows([20, 12, 12]), &PLASTER);
        let number = |x: &Vec3, k| unit(3, k, x.x.to_bits() ^ x.y.to_bits() ^ x.z.to_bits()) - 0.5;
        domain.launch(|x| x * 100.0 + 20.0 * Vec3::new(number(x, 0), number(x, 1), number(x, 2)));
        let tallies: Vec<_> = (0..40).map(|_| domain.advance()).collect();
        let lost: Vec<f64> = tallies.iter().map(|tally| tally.dissipated).collect();
        let nodes = &domain.grid.nodes;
        let motion: Vec<f64> = nodes.velocity.iter().map(|v| v.reduce_add()).collect();
        (tallies, lost, motion, domain.particles.damage.clone())
    };
    let one = on(1, shatter);
    assert!(one.1.iter().filter(|lost| **lost > 0.0).count() >= 8, "it shatters");
    let (to, fro) = (one.2.iter().sum::<f64>(), one.2.iter().rev().sum::<f64>());
    assert_ne!(to.to_bits(), fro.to_bits(), "the order of a sum is in its bits");
    for threads in [2, 3, 7, 1] {
        assert!(on(threads, shatter) == one, "{threads} threads");
    }
    let hit = blow(Vec3::new(-0.05, 0.01, 0.015), Vec3::x(), 1.0);
    let problem = problem(cuboid(Vec3::repeat(10.0 * H)), PLASTER, hit);
    let one = on(1, || solved(&problem));
    assert!(
        one.report.detail("damaged_fraction").unwrap_or_default() > 0.01
            && one == on(3, || solved(&problem))
    );
    assert_ne!(one, solved(&BrittleProblem { seed: 8, ..problem }));
}

/// F76: one number that is none, anywhere in the nodes' motion, is seen, and ends a solve by name.
#[test]
fn f76_one_number_that_is_none_is_seen() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut domain = body(&rows([3, 3, 3]), &STRONG);
        assert!(domain.is_finite());
        let middle = domain.grid.nodes.len() / 2;
        domain.grid.nodes.velocity[middle] = domain.grid.nodes.velocity[middle] * value + value;
        assert!(!domain.is_finite(), "{value}");
        domain.advance();
        assert!(!domain.is_finite(), "{value} after a step");
        let seen = Diagnostics::default().check(&domain, None);
        assert!(matches!(seen, Err(Failure::NotFinite { step: 1, .. })), "{seen:?}");
    }
}

/// What a scene of one body above a floor says of a material with that line in it.
fn told(line: &str) -> Result<Vec<String>, String> {
    let text = format!(
        "[[material]]\nname = \"m\"\npreset = \"granite\"\n{line}\n[[body]]\nname = \"b\"\n\
         shape = {{ kind = \"box\", size = [1, 1, 1] }}\nmaterial = \"m\"\nposition = [0, 0, 1]\n\
         [[body]]\nname = \"floor\"\nshape = {{ kind = \"box\", size = [9, 9, 1] }}\nfixed = true\n\
         position = [0, 0, -1]\nmaterial = \"granite\"\n"
    );
    let key = "scene/scene.toml".to_owned();
    let files = vec![SceneFile { key: key.clone(), bytes: Arc::new(text.into_bytes()) }];
    let bundle = Bundle { name: "units".to_owned(), main: key, overrides: Vec::new(), files };
    load_bundle(&bundle).map(|scene| scene.warnings).map_err(|errors| errors.to_string())
}

/// F77: a unit that was mistaken shows in what follows from it: refused where nothing can break
/// so, told where it is only unusual.
#[test]
fn f77_mistaken_units_are_refused_or_told() {
    assert_eq!(told(""), Ok(Vec::new()));
    let kilo = told("strength = \"10 kPa\"").expect_err("too weak");
    assert!(kilo.contains("strength over Young's modulus must lie in [1e-5, 20]"), "{kilo}");
    let giga = told("strength = \"10 GPa\"").expect_err("too strong for a rigid body that breaks");
    assert!(giga.contains("strength over Young's modulus must lie in [1e-5, 0.1]"), "{giga}");
    let cases = [
        ("fracture_energy = 0.01", "K_Ic = √(E·G_f) is"),
        ("fracture_energy = 9e6", "K_Ic = √(E·G_f) is"),
        ("density = 2.6", "pressure waves would run at"),
    ];
    for (line, words) in cases {
        let warnings = told(line).unwrap_or_else(|errors| panic!("{line}: {errors}"));
        assert!(warnings.iter().any(|w| w.contains(words)), "{line}: {warnings:?}");
    }
}

/// F78: solves that differ in nothing but their seed come to other numbers of fragments, by more
/// than the mean of eight can be trusted to; the means of two eights agree within their bands. One
/// run has no band, and a standing set takes no ensemble of fewer than eight.
#[test]
fn f78_one_run_is_not_the_truth() {
    let hit = blow(Vec3::new(-0.05, 0.01, 0.015), Vec3::x(), 1.0);
    let count = |seed: u64| {
        let mut problem = problem(cuboid(Vec3::repeat(0.1)), PLASTER, hit);
        (problem.seed, problem.strength.seed) = (seed, seed);
        solved(&problem).fragments.len() as f64
    };
    let counts: Vec<f64> = (0..16).map(count).collect();
    let [first, second] = [&counts[..8], &counts[8..]].map(|eight| ensemble(eight).expect("eight"));
    let [one, two] = [first, second].map(|eight| eight.half.expect("a band"));
    println!("{counts:?}: {} ± {one}, {} ± {two}", first.mean, second.mean);
    let furthest = counts.iter().map(|n| (n - first.mean).abs()).fold(0.0, f64::max);
    assert!(one > 0.0 && furthest > one, "{furthest} and {one}");
    assert!((first.mean - second.mean).abs() < one + two, "{counts:?}");
    assert_eq!(ensemble(&counts[..1]).expect("one").half, None);

    let folder = std::env::temp_dir().join(format!("cullet-f78-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let set = "[[chart]]\nname = \"bar\"\ntitle = \"a bar\"\nspecimen = \"bar.toml\"\n\
         metric = \"most\"\nalong = \"spacing=2cm\"\nseeds = 3\n\
         [[chart.option]]\nname = \"double\"\n";
    std::fs::write(folder.join("set.toml"), set).expect("a file");
    let refused = frontier::load(&folder.join("set.toml"), &[], false).map(|_| ());
    std::fs::remove_dir_all(&folder).expect("it is there");
    let words = refused.expect_err("too few").to_string();
    assert!(words.contains("at least 8; it is 3"), "{words}");
}
