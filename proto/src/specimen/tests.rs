use super::*;
use crate::codec::WireError;
use crate::job::tests::tetrahedron;
use cullet_geometry::{Mat3, Quat, Vec3};
use cullet_model::strength::Region;
use cullet_model::{Material, PointPrecision, StrengthField, SurfaceLaw};

fn settings() -> SpecimenSettings {
    SpecimenSettings {
        spacing: 0.01,
        step_factor: 0.8,
        precision: PointPrecision::Double,
        breaks: true,
        damping: 0.0,
        damped_until: None,
        max_points: 1e6,
        max_steps: 1e6,
        threads: 2,
        seed: 3,
        points: PointSettings {
            per_cell: 8.0,
            layout: PointLayout::Rows,
            welded: false,
            softening_length: None,
            look: 4,
        },
        horizon: None,
    }
}

fn job() -> SpecimenJob {
    let part = vec![Region::Sphere { centre: Vec3::zeros(), radius: 1.0 }];
    let material = Material {
        density: 1.0,
        young: 2.0,
        poisson: 0.2,
        failure_stress: 3.0,
        fracture_energy: 4.0,
    };
    let hold = Hold {
        part: part.clone(),
        axes: [true, false, true],
        velocity: Vec3::new(1.0, 2.0, 3.0),
        gradient: Mat3::from_fn(|i, j| (3 * i + j) as f64),
        centre: Vec3::zeros(),
        course: Amplitude::HalfSine { start: 0.0, duration: 1.0 },
        until: Some(2.0),
    };
    SpecimenJob(SpecimenProblem {
        family: "brittle".to_owned(),
        body: SpecimenBody {
            mesh: tetrahedron().mesh,
            parts: vec![2],
            turn: Quat::identity(),
            shift: Vec3::new(0.0, 0.5, 0.0),
        },
        matter: Matter {
            material,
            surface: SurfaceLaw::of(&material),
            flow: None,
            zones: vec![Zone { part: part.clone(), material }],
            strength: StrengthField {
                weak_plane: Some(cullet_model::PatternWeakPlane { normal: Vec3::x(), ratio: 0.5 }),
                ..Default::default()
            },
            patches: vec![StrengthPatch { part: part.clone(), strength: 2.0, damage: 0.0 }],
        },
        initial: InitialState::default(),
        holds: vec![hold],
        symmetries: vec![SymmetryPlane { axis: 1, at: 0.5 }],
        loads: Vec::new(),
        output: Output {
            end: 1.0,
            probes: vec![Probe::Kinetic, Probe::Broken(part)],
            samples: 10,
            frames: 0,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: settings(),
    })
}

#[test]
fn a_specimen_comes_back_as_it_went_and_threads_do_not_name_it() -> Result<(), WireError> {
    let first = job();
    assert_eq!(SpecimenJob::decode(&first.encode()?)?, first);
    let mut other = first.clone();
    other.0.settings.threads = 7;
    assert_eq!(first.id()?, other.id()?);
    other.0.settings.seed = 4;
    assert_ne!(first.id()?, other.id()?);
    Ok(())
}

/// A horizon travels, and names the job; one without is as it was.
#[test]
fn a_horizon_is_a_message_of_its_own() -> Result<(), WireError> {
    let (plain, mut other) = (job(), job());
    assert_eq!(bytes(&plain), plain.encode()?);
    for horizon in [2.04, 4.0] {
        other.0.settings.horizon = Some(horizon);
        let sent = other.encode()?;
        assert!(SpecimenJob::is(&sent) && SpecimenJob::is(&plain.encode()?));
        assert_eq!(envelope::split(&sent)?.0, MessageKind::HorizonSpecimen as u16);
        assert_eq!(SpecimenJob::decode(&sent)?, other);
        assert_ne!(plain.id()?, other.id()?);
    }
    other.0.settings.horizon = Some(f64::NAN);
    assert!(other.encode().is_err());
    Ok(())
}

/// A job as bytes whose problem nothing was held to.
fn bytes(job: &SpecimenJob) -> Vec<u8> {
    let solid = Solid::outer(job.0.body.mesh.clone());
    let (vertices, triangles) = mesh::counts(&solid).expect("a mesh");
    let mut slabs = Vec::new();
    mesh::put_solid(&mut slabs, &solid);
    envelope::seal(MessageKind::Specimen, &(&job.0, vertices, triangles), &slabs).expect("sealed")
}

/// Words of an error, and what brings it about.
type Spoiled<'a> = (&'a str, &'a dyn Fn(&mut SpecimenProblem));

/// What is wrong is reported on arrival, before anything is solved.
#[test]
fn bad_numbers_and_indices_are_told_at_the_door() {
    let line = |rows: &[(f64, f64)]| Load {
        part: Vec::new(),
        push: LoadKind::Pressure(1.0),
        course: Amplitude::Table(rows.to_vec()),
    };
    let none = Quat::new_unchecked(Quat::identity().into_inner() * 0.0);
    let cases: [Spoiled<'_>; 18] = [
        ("support of a probe is 2", &|s| {
            s.output.probes = vec![Probe::Reaction(1, TensorPart::Size)];
        }),
        ("load of a probe is 4", &|s| s.output.probes = vec![Probe::Applied(3, TensorPart::Size)]),
        ("axis of a probe is 3", &|s| s.output.probes = vec![Probe::Momentum(TensorPart::Axis(3))]),
        ("share of a probe is 1.5", &|s| {
            let (part, along) = (Vec::new(), Vec3::x());
            s.output.probes = vec![Probe::CrackTip { part, along, share: 1.5, otherwise: 0.0 }];
        }),
        ("share of a probe is NaN", &|s| s.output.probes = vec![Probe::Pieces(f64::NAN)]),
        ("direction of a probe is not finite", &|s| {
            s.output.probes = vec![Probe::CrackArea(Vec::new(), Vec3::zeros())];
        }),
        ("frames is 10001", &|s| s.output.frames = 10_001),
        ("family is 65", &|s| s.family = "x".repeat(65)),
        ("material is not finite", &|s| s.matter.material.young = f64::NAN),
        ("material is not finite", &|s| s.matter.zones[0].material.density = f64::INFINITY),
        ("strength is not finite", &|s| s.matter.strength.weibull = f64::INFINITY),
        ("turn is not finite", &|s| s.body.turn = none),
        ("settings is not finite", &|s| s.settings.damped_until = Some(f64::NAN)),
        ("region of a specimen is not finite", &|s| {
            let centre = Vec3::new(0.0, f64::NAN, 0.0);
            s.matter.patches[0].part = vec![Region::Sphere { centre, radius: 1.0 }];
        }),
        ("first triangle of a body is 5", &|s| s.body.parts = vec![4]),
        ("behind 2", &|s| s.body.parts = vec![2, 2]),
        ("plane of symmetry is 3", &|s| s.symmetries = vec![SymmetryPlane { axis: 3, at: 0.0 }]),
        ("1 s follows 2 s", &|s| s.loads = vec![line(&[(2.0, 0.0), (1.0, 1.0)])]),
    ];
    assert_eq!(SpecimenJob::decode(&bytes(&job())), Ok(job()));
    for (words, spoil) in cases {
        let mut job = job();
        spoil(&mut job.0);
        let told = SpecimenJob::decode(&bytes(&job)).expect_err(words).to_string();
        assert!(told.contains(words), "{words}: {told}");
        assert!(job.encode().is_err(), "{words}");
    }
}
