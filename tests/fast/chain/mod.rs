//! A second family, as small as one can be: point masses on a line with springs between them. The
//! specimens of waves in bars and of cantilevers hold it to the same formulas as the brittle one.

mod body;

use body::Chain;
use cullet_lab::specimen::load;
use cullet_lab::{Measured, SweepPoint};
use cullet_model::{PointPrecision, Refusal};
use cullet_proto::specimen::Ending;
use cullet_specimen::{Discrete, Feature, GridFrame, PointField, SpecimenFamily, SpecimenProblem};
use cullet_tests::root;
use cullet_worker::specimen::{solve, solve_with};

const CHAIN: SpecimenFamily =
    SpecimenFamily { name: "chain", features: FEATURES, build: |problem| discrete(problem, 1.0) };

/// The same with springs that are a tenth too stiff.
const TOO_STIFF: SpecimenFamily =
    SpecimenFamily { build: |problem| discrete(problem, 1.1), ..CHAIN };

/// The same with masses that are a tenth too heavy.
const TOO_HEAVY: SpecimenFamily = SpecimenFamily {
    build: |problem| {
        let mut heavy = problem.clone();
        heavy.matter.material.density *= 1.1;
        discrete(&heavy, 1.0)
    },
    ..CHAIN
};

const FEATURES: &[Feature] = &[
    Feature::Field(PointField::Displacement),
    Feature::Field(PointField::Velocity),
    Feature::Field(PointField::Stress),
    Feature::Precision(PointPrecision::Double),
    Feature::Acceleration,
    Feature::Support,
    Feature::Damping,
    Feature::Turn,
];

fn discrete(problem: &SpecimenProblem, stiffness: f64) -> Result<Discrete, Refusal> {
    let chain = Chain::new(problem, stiffness)?;
    Ok(Discrete {
        points: chain.len() as u64,
        stable_step: chain.stable_step(),
        strength_ratio: 1.0,
        // It lies along the specimen, wherever its grid is.
        frame: GridFrame::default(),
        loads: chain.loads(),
        body: Box::new(chain),
    })
}

/// A specimen of the catalogue, by a family of this table.
fn measured(name: &str, overrides: &[&str], table: &[SpecimenFamily]) -> Measured {
    let file = root().join("tests/specimens").join(format!("{name}.toml"));
    let overrides: Vec<String> =
        ["family=chain"].iter().chain(overrides).map(|&text| text.to_owned()).collect();
    let specimen = load(&file, &overrides).expect("a specimen");
    let job = specimen.job().expect("a body");
    let result = solve_with(job, table);
    Measured::new(SweepPoint { specimen, swept: Vec::new() }, result)
}

fn value(measured: &Measured, metric: &str) -> f64 {
    measured.rows.iter().find(|row| row.metric == metric).expect("the metric").value
}

/// The names of the metrics that are not what they must be.
fn missed(measured: &Measured) -> Vec<&str> {
    use cullet_lab::specimen::MetricVerdict;
    let rows = measured.rows.iter().filter(|row| row.weighed.verdict == MetricVerdict::Fails);
    rows.map(|row| row.metric.as_str()).collect()
}

/// E3 as it stands in the catalogue: six numbers of a wave in a bar.
#[test]
fn a_chain_carries_a_wave_as_the_catalogue_asks() {
    let wave = measured("e3-bar-wave", &[], &[CHAIN]);
    assert_eq!((wave.result.ending.clone(), wave.result.points), (Ending::Ok, 101));
    assert_eq!((missed(&wave), wave.rows.len()), (Vec::new(), 6));
    assert!(!wave.fails());
    // No metric sees that it was another family: its numbers are not those of the other to a bit.
    assert_eq!(wave.point.specimen.solver, "chain");
}

/// E7 as it stands: the sag of a cantilever under its weight, and what its wall bears.
#[test]
fn a_chain_bends_as_the_catalogue_asks() {
    let cantilever = measured("e7-cantilever", &[], &[CHAIN]);
    assert_eq!((missed(&cantilever), cantilever.rows.len()), (Vec::new(), 2));
    assert!(!cantilever.fails());
    // Shear, which turning springs do not have, is 0.8 % of the sag; the trapezoids add Δ²/L².
    let bending = 9.81 * 0.01 * 10.0 / (8.0 * 1e7 * 0.1_f64.powi(4) / 12.0);
    let wanted = -bending * (1.0 + 1.0 / 900.0);
    let sag = value(&cantilever, "sag");
    assert!((sag / wanted - 1.0).abs() < 1e-4, "{sag} of {wanted}");
}

/// The expectations have teeth: a chain that is wrong by a tenth does not meet them.
#[test]
fn a_chain_that_is_wrong_is_found_out() {
    let stiff = measured("e3-bar-wave", &[], &[TOO_STIFF]);
    assert_eq!(missed(&stiff), ["arrival", "arrival at the end", "stress", "push"]);
    let heavy = measured("e3-bar-wave", &[], &[TOO_HEAVY]);
    assert_eq!(missed(&heavy), ["arrival", "arrival at the end", "stress", "push"]);
    assert_eq!(missed(&measured("e7-cantilever", &[], &[TOO_STIFF])), ["sag"]);
    let heavy = measured("e7-cantilever", &[], &[TOO_HEAVY]);
    assert_eq!(missed(&heavy), ["sag", "reaction"]);
    assert!(stiff.fails() && heavy.fails());
}

/// A wave is late by the chain's own dispersion, which goes as the square of the spacing.
#[test]
fn a_finer_chain_is_nearer() {
    let late = |spacing: &str| {
        let wave = measured("e3-bar-wave", &[spacing], &[CHAIN]);
        value(&wave, "arrival at the end") / 304.699e-6 - 1.0
    };
    let (coarse, fine) = (late("spacing=2cm").abs(), late("spacing=5mm").abs());
    assert!(fine < 1e-3 && fine < coarse, "{coarse} {fine}");
}

/// What a family has not is told with what it has, before anything is solved.
#[test]
fn what_a_family_has_not_is_refused_with_what_it_has() {
    let told =
        |name: &str, overrides: &[&str]| match measured(name, overrides, &[CHAIN]).result.ending {
            Ending::Refused(why) => why,
            other => panic!("{name}: {other:?}"),
        };
    let bar = "e3-bar-wave";
    let brittle = ["breaks=true", "material.strength=1 MPa", "material.fracture_energy=1"];
    let cases = [
        (told(bar, &["family=chian"]), "no family \"chian\"", "there are: chain"),
        (told(bar, &["precision=single"]), "has no precision single", "precision double"),
        (told(bar, &brittle), "has no material that breaks", "support"),
        (told(bar, &["colour=damage"]), "has no field damage", "field velocity"),
        (told("e3-dispersion", &[]), "has no velocity at the start", "damping"),
        (told("k7-disc", &[]), "has no patch", "load by acceleration"),
    ];
    for (why, what, has) in cases {
        assert!(why.contains(what) && why.contains(has), "{why}");
    }
    // The worker's own table has no chain: it says which it has.
    let specimen = measured(bar, &[], &[CHAIN]).point.specimen;
    let ending = solve(specimen.job().expect("a body")).outcome.ending;
    let known = "there are: brittle, ductile, shell, peridynamics, membrane";
    let wanted = format!("there is no family \"chain\" for specimens; {known}");
    assert_eq!(ending, Ending::Refused(wanted));
}
