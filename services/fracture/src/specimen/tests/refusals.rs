//! What is reported before anything is solved.

use super::{STONE, bar, begun, face};
use cullet_geometry::{Mat3, Vec3};
use cullet_model::Refusal;
use cullet_specimen::{
    Amplitude, Hold, Load, LoadKind, Notch, PointField, Probe, SpecimenProblem, Spot, Start,
    StrengthPatch, SymmetryPlane, TensorPart, Unfit, Where, Zone,
};

#[test]
fn what_cannot_be_solved_is_refused_with_its_bound() {
    let what = |change: &dyn Fn(&mut SpecimenProblem)| {
        let mut specimen = bar(0.1, 0.02, 0.01);
        assert!(begun(specimen.clone()).is_ok());
        change(&mut specimen);
        match begun(specimen).map(|_| ()) {
            Err(Unfit::Refused(
                Refusal::OutOfRange { what, .. } | Refusal::TooLarge { what, .. },
            )) => what,
            other => panic!("{other:?}"),
        }
    };
    assert!(what(&|s| s.settings.max_points = 10.0).contains("points"));
    assert!(what(&|s| s.settings.max_steps = 10.0).contains("steps"));
    assert!(what(&|s| s.settings.spacing = 0.0).contains("spacing"));
    assert!(what(&|s| s.matter.material.poisson = 0.5).contains("Poisson"));
    let plane = SymmetryPlane { axis: 0, at: 0.0033 };
    assert!(what(&|s| s.symmetries = vec![plane]).contains("symmetry"));
}

#[test]
fn bodies_that_overlap_are_refused() {
    let mut specimen = bar(0.2, 0.02, 0.01);
    let other = specimen.body.mesh.translated(Vec3::x() * 0.19);
    specimen.body.parts = vec![specimen.body.mesh.triangles.len() as u32];
    specimen.body.mesh.append(&other);
    let refusal = begun(specimen).expect_err("they overlap");
    assert!(refusal.to_string().contains("bodies may touch, not overlap"), "{refusal}");
}

/// A region beside the body: the load or support in it would do nothing, and nobody would know.
#[test]
fn what_acts_on_nothing_is_refused_by_its_number() {
    let beside = || face(0, 5.0, true);
    let load = |part, push| Load { part, push, course: Amplitude::Table(vec![(0.0, 1.0)]) };
    let pull = |size: f64| LoadKind::Traction(Vec3::x() * size);
    let mut loads = vec![load(face(0, 0.1, true), pull(1.0)), load(beside(), pull(1.0))];
    let said = |loads: &[Load], holds: &[Hold]| {
        let (loads, holds) = (loads.to_vec(), holds.to_vec());
        let specimen = SpecimenProblem { loads, holds, ..bar(0.1, 0.04, 0.01) };
        begun(specimen).err().map(|refusal| refusal.to_string())
    };
    assert!(said(&loads, &[]).is_some_and(|text| text.starts_with("load 2 takes nothing")));
    // Nothing is put on nothing: a sweep from zero on.
    loads[1].push = pull(0.0);
    assert_eq!(said(&loads, &[]), None);
    for push in
        [LoadKind::Pressure(1.0), LoadKind::Force(Vec3::x()), LoadKind::Acceleration(Vec3::x())]
    {
        loads[1].push = push;
        assert!(said(&loads, &[]).is_some());
    }
    let hold = |part| Hold {
        part,
        axes: [true; 3],
        velocity: Vec3::zeros(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::Table(vec![(0.0, 1.0)]),
        until: None,
    };
    assert_eq!(said(&[], &[hold(face(0, 0.0, false))]), None);
    let told = said(&[], &[hold(face(0, 0.0, false)), hold(beside())]);
    assert!(told.is_some_and(|text| text.starts_with("support 2 takes nothing")));
}

/// The same of what is there at the start, and of a place that is read far beside the body.
#[test]
fn what_takes_nothing_is_refused_by_its_number() {
    let start = |part| Start {
        part,
        velocity: Vec3::x(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        noise: 0.0,
    };
    let notch = |part| Notch { point: Vec3::x() * 0.05, normal: Vec3::x(), part };
    let probe = |x| Probe::Points(PointField::Velocity, TensorPart::Size, Spot::At(Vec3::x() * x));
    let patch = |part| StrengthPatch { part, strength: 2.0, damage: 0.0 };
    let zone = |part| Zone { part, material: STONE };
    let said = |pick: &dyn Fn(&mut SpecimenProblem, Where, f64)| {
        let mut specimen = bar(0.1, 0.04, 0.01);
        specimen.settings.breaks = true;
        pick(&mut specimen, Vec::new(), 0.11);
        assert!(begun(specimen.clone()).is_ok());
        pick(&mut specimen, face(0, 5.0, true), 0.13);
        begun(specimen).expect_err("a mistake").to_string()
    };
    let told = [
        said(&|s, part, _| s.matter.zones.push(zone(part))),
        said(&|s, part, _| s.matter.patches.push(patch(part))),
        said(&|s, part, _| s.initial.starts.push(start(part))),
        said(&|s, part, _| s.initial.notches.push(notch(part))),
        said(&|s, _, x| s.output.probes.push(probe(x))),
    ];
    for (text, what) in told.iter().zip(["zone", "patch", "start", "notch", "probe"]) {
        assert!(text.starts_with(&format!("{what} 2 takes nothing")), "{text}");
    }
}
