//! Plates of the catalogue as shells, and as shells that are wrong: their expectations have teeth.

use cullet_lab::specimen::{MetricVerdict, load};
use cullet_lab::{Measured, SweepPoint};
use cullet_proto::specimen::Ending;
use cullet_shell::specimen::FAMILY;
use cullet_specimen::{SpecimenFamily, SpecimenProblem};
use cullet_tests::root;
use cullet_worker::specimen::solve_with;

/// The same with another material or load.
const fn wrong(
    build: fn(&SpecimenProblem) -> Result<cullet_specimen::Discrete, cullet_model::Refusal>,
) -> SpecimenFamily {
    SpecimenFamily { build, ..FAMILY }
}

const TOO_STIFF: SpecimenFamily = wrong(|problem| {
    let mut stiff = problem.clone();
    stiff.matter.material.young *= 1.05;
    (FAMILY.build)(&stiff)
});

const TOO_HEAVY: SpecimenFamily = wrong(|problem| {
    let mut heavy = problem.clone();
    heavy.matter.material.density *= 1.05;
    (FAMILY.build)(&heavy)
});

/// As if the law projected three dimensions: Poisson's ratio ν/(1 − ν).
const PLANE_STRAIN: SpecimenFamily = wrong(|problem| {
    let mut strained = problem.clone();
    let m = &mut strained.matter.material;
    let projected = m.poisson / (1.0 - m.poisson);
    m.young *= 1.0 / (1.0 - m.poisson * m.poisson);
    m.poisson = projected;
    (FAMILY.build)(&strained)
});

/// The metrics of a specimen of the catalogue that are not what they must be.
fn missed(name: &str, overrides: &[&str], family: SpecimenFamily) -> Vec<String> {
    let file = root().join("tests/specimens").join(format!("{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let specimen = load(&file, &overrides).expect("a specimen");
    let result = solve_with(specimen.job().expect("a body"), &[family]);
    assert_eq!(result.outcome.ending, Ending::Ok, "{name}");
    let measured = Measured::new(SweepPoint { specimen, swept: Vec::new() }, result);
    let rows = measured.rows.iter().filter(|row| row.weighed.verdict == MetricVerdict::Fails);
    rows.map(|row| row.metric.clone()).collect()
}

#[test]
fn a_plate_sags_as_the_catalogue_asks_and_a_wrong_one_does_not() {
    let sag = |family| missed("e9-plate", &["frames=1", "samples=40"], family);
    assert_eq!(sag(FAMILY), Vec::<String>::new());
    assert_eq!(sag(TOO_STIFF), ["sag"]);
    assert_eq!(sag(PLANE_STRAIN), ["sag", "stress"]);
}

#[test]
fn a_plate_rings_as_the_catalogue_asks_and_a_wrong_one_does_not() {
    let ring = |family| missed("e8-plate", &["frames=1", "end=6ms", "samples=400"], family);
    assert_eq!(ring(FAMILY), Vec::<String>::new());
    assert_eq!(ring(TOO_HEAVY), ["period"]);
}
