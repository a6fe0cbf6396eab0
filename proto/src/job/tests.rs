//! Jobs on the wire.

use super::*;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use cullet_model::strength::{Region, StrengthLayers, Stroke, VertexPaint};
use cullet_model::{
    BodyRegion, BondGrain, DuctileFailure, Interlayer, PatternWeakPlane, ThermalSoftening,
};
use std::sync::Arc;

pub(crate) fn tetrahedron() -> Solid {
    let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mut solid = Solid::outer(TriMesh { vertices, triangles });
    solid.surface[3] = Surface::crack(1.5e-5);
    solid
}

fn strength() -> StrengthField {
    StrengthField {
        seed: 3,
        correlation: Some(0.02),
        weak_plane: Some(PatternWeakPlane { normal: Vec3::z(), ratio: 0.3 }),
        layers: Some(StrengthLayers { normal: Vec3::y(), thickness: 0.1, ratio: 0.5, jitter: 0.2 }),
        strokes: vec![
            Stroke {
                region: Region::Box { low: Vec3::zeros(), high: Vec3::repeat(1.0) },
                factor: 0.5,
                edge: 0.01,
            },
            Stroke {
                region: Region::Sphere { centre: Vec3::zeros(), radius: 1.0 },
                factor: 0.5,
                edge: 0.0,
            },
            Stroke {
                region: Region::HalfSpace { point: Vec3::zeros(), normal: Vec3::repeat(1.0) },
                factor: 2.0,
                edge: 0.0,
            },
            Stroke {
                region: Region::Cylinder {
                    from: Vec3::zeros(),
                    to: Vec3::repeat(1.0),
                    radius: 0.2,
                },
                factor: 2.0,
                edge: 0.0,
            },
        ],
        vertices: Some(Arc::new(VertexPaint {
            points: vec![Vec3::x(), Vec3::y()],
            factors: vec![0.5, 1.0],
            reach: 0.1,
        })),
        ..StrengthField::even()
    }
}

pub(crate) fn sample() -> FractureJob {
    let material = Material {
        density: 2500.0,
        young: 7e10,
        poisson: 0.22,
        failure_stress: 4e7,
        fracture_energy: 8.0,
    };
    let impact = Impact {
        point: Vec3::new(0.1, 0.2, 0.3),
        normal: -Vec3::z(),
        impulse: 0.5,
        duration: 1e-4,
        radius: 1e-3,
        energy: 2.0,
        closing_speed: 3.0,
        crushing_pressure: 1e9,
    };
    let (point, normal) = (Vec3::zeros(), Vec3::z());
    let detail = CrackFaceDetail { height: 0.1, ..CrackFaceDetail::default() };
    let problem = Problem {
        body: tetrahedron().into(),
        law: Law::Brittle {
            material,
            strength: strength(),
            surface: SurfaceLaw { hardness: 2e8, friction: 0.7 },
        },
        impacts: vec![impact],
        supports: vec![Support { point, normal, radius: 0.02, mobility: 0.5 }],
        spin: Vec3::new(0.0, 0.0, 100.0),
        settings: Settings {
            grain: Some(1e-3),
            error: Some(0.5),
            brittle: BrittleSettings { detail, hairline: Some(1e-4) },
            ..Settings::default()
        },
        seed: 7,
    };
    let fallback = Some("geometric".into());
    FractureJob { solver: "brittle".into(), fallback, problem, direction: None }
}

fn solid(job: &mut FractureJob) -> &mut Solid {
    let BodyShape::Solid(solid) = &mut job.problem.body else { panic!("another body") };
    Arc::make_mut(solid)
}

fn law(job: &mut FractureJob) -> (&mut Material, &mut StrengthField) {
    let Law::Brittle { material, strength, .. } = &mut job.problem.law else {
        panic!("another law")
    };
    (material, strength)
}

fn surface(job: &mut FractureJob) -> &mut SurfaceLaw {
    let Law::Brittle { surface, .. } = &mut job.problem.law else { panic!("another law") };
    surface
}

fn paint(job: &mut FractureJob) -> &mut VertexPaint {
    Arc::make_mut(law(job).1.vertices.as_mut().expect("paint"))
}

#[test]
fn a_job_comes_back_and_its_id_is_fixed() -> Result<(), WireError> {
    let job = sample();
    let bytes = job.encode()?;
    assert_eq!(FractureJob::decode(&bytes)?, job);
    assert_eq!(job.id()?, JobId::of(&bytes));
    assert_eq!(job.id()?.short(), "5113d819");
    Ok(())
}

#[test]
fn a_directed_job_comes_back_and_one_that_is_not_keeps_its_bytes() -> Result<(), WireError> {
    let plain = sample();
    let region = BodyRegion::Ball { centre: Vec3::x(), radius: 0.1 };
    let direction = |pieces| ArtDirection {
        pieces: Some(pieces),
        guides: vec![Vec3::x(), Vec3::new(0.1, -0.2, 0.3)],
        whole: vec![region, BodyRegion::Box { low: -Vec3::x(), high: Vec3::z() }],
    };
    let job = FractureJob { direction: Some(direction(24)), ..plain.clone() };
    let bytes = job.encode()?;
    assert_eq!(FractureJob::decode(&bytes)?, job);
    assert_eq!(job.id()?.short(), "252a3236");
    assert!(bytes.ends_with(&plain.encode()?), "the job itself travels as it is");
    let (_, slabs) = job.slabs()?;
    let (own, places) = plain.slabs()?;
    for (slab, place) in slabs.into_iter().zip(places) {
        assert_eq!(bytes[slab], own[place], "the mesh is found where it is");
    }
    for end in 0..bytes.len() {
        assert!(FractureJob::decode(&bytes[..end]).is_err(), "{end} of {}", bytes.len());
    }
    let wrong = |direction| FractureJob { direction: Some(direction), ..plain.clone() }.encode();
    assert!(matches!(wrong(direction(MAX_PIECES + 1)), Err(WireError::Limit { .. })));
    let nowhere = ArtDirection { guides: vec![Vec3::repeat(f64::NAN)], ..direction(9) };
    assert_eq!(wrong(nowhere), Err(WireError::NotFinite { what: "a job's guide points" }));
    let radius = BodyRegion::Ball { centre: Vec3::x(), radius: f64::INFINITY };
    let endless = ArtDirection { whole: vec![radius], ..direction(9) };
    assert_eq!(wrong(endless), Err(WireError::NotFinite { what: "a job's whole regions" }));
    let many = ArtDirection { guides: vec![Vec3::x(); MAX_GUIDES + 1], ..direction(9) };
    assert!(matches!(wrong(many), Err(WireError::Limit { .. })));
    let twice = envelope::seal(MessageKind::DirectedJob, &direction(9), &bytes)?;
    assert!(matches!(FractureJob::decode(&twice), Err(WireError::Kind { .. })));
    Ok(())
}

#[test]
fn a_job_of_treated_glass_comes_back_and_its_id_is_its_own() -> Result<(), WireError> {
    let interlayer = Interlayer { thickness: 0.76e-3, strength: 20e6, stretch: 2.0 };
    let all = [
        Treatment::HeatStrengthened { surface_stress: 40e6 },
        Treatment::Toughened { surface_stress: 40e6 },
        Treatment::Toughened { surface_stress: 90e6 },
        Treatment::Laminated { interlayer },
    ];
    let mut ids = vec![sample().id()?];
    for treatment in all {
        let mut job = sample();
        let (material, strength) = law(&mut job);
        let (material, strength) = (*material, strength.clone());
        job.problem.law = Law::Treated { material, strength, treatment };
        let bytes = job.encode()?;
        assert_eq!(FractureJob::decode(&bytes)?, job);
        assert!(!ids.contains(&job.id()?), "{treatment:?}");
        ids.push(job.id()?);
    }
    assert_eq!(ids[2].short(), "daa5f386");
    let mut job = sample();
    let (material, strength) = law(&mut job);
    let (material, strength) = (*material, strength.clone());
    let treatment = Treatment::Toughened { surface_stress: f64::NAN };
    job.problem.law = Law::Treated { material, strength, treatment };
    assert_eq!(job.encode(), Err(WireError::NotFinite { what: "a job's treatment" }));
    Ok(())
}

#[test]
fn a_job_of_metal_comes_back_and_its_id_is_its_own() -> Result<(), WireError> {
    let metal = |yield_stress, exponent| {
        let mut job = sample();
        let material = *law(&mut job).0;
        let hardening = Hardening { yield_stress, hardening: 400e6, exponent };
        job.problem.law = Law::Yielding { material, hardening };
        job
    };
    let job = metal(200e6, 0.45);
    let bytes = job.encode()?;
    assert_eq!(FractureJob::decode(&bytes)?, job);
    assert_eq!(job.id()?.short(), "a5982f1a");
    for other in [sample(), metal(201e6, 0.45), metal(200e6, 0.5)] {
        assert_ne!(job.id()?, other.id()?);
    }
    let wrong = metal(f64::INFINITY, 0.45).encode();
    assert_eq!(wrong, Err(WireError::NotFinite { what: "a job's hardening" }));
    for end in 0..bytes.len() {
        assert!(FractureJob::decode(&bytes[..end]).is_err(), "{end} of {}", bytes.len());
    }
    Ok(())
}

#[test]
fn a_job_of_metal_that_tears_comes_back_and_its_id_is_its_own() -> Result<(), WireError> {
    let flow = JohnsonCook {
        hardening: Hardening { yield_stress: 792e6, hardening: 510e6, exponent: 0.26 },
        rate: 0.014,
        reference_rate: 1.0,
        softening: Some(ThermalSoftening {
            melting: 1500.0,
            exponent: 1.03,
            heat_capacity: 477.0,
            heat_share: 0.9,
        }),
        failure: Some(DuctileFailure { d: [0.05, 3.44, -2.12, 0.002, 0.61] }),
    };
    let metal = |flow: JohnsonCook| {
        let mut job = sample();
        job.problem.law = Law::JohnsonCook { material: *law(&mut job).0, flow };
        job
    };
    let job = metal(flow);
    let bytes = job.encode()?;
    assert_eq!(FractureJob::decode(&bytes)?, job);
    let others =
        [JohnsonCook { failure: None, ..flow }, JohnsonCook { rate: 0.0, ..flow }].map(metal);
    for other in others {
        assert_eq!(FractureJob::decode(&other.encode()?)?, other);
        assert_ne!(job.id()?, other.id()?);
    }
    let failure = Some(DuctileFailure { d: [f64::NAN, 0.0, 0.0, 0.0, 0.0] });
    let wrong = metal(JohnsonCook { failure, ..flow }).encode();
    assert_eq!(wrong, Err(WireError::NotFinite { what: "a job's flow" }));
    for end in 0..bytes.len() {
        assert!(FractureJob::decode(&bytes[..end]).is_err(), "{end} of {}", bytes.len());
    }
    Ok(())
}

#[test]
fn a_job_of_bonds_comes_back_and_its_id_is_its_own() -> Result<(), WireError> {
    let axis = Vec3::new(0.6, 0.0, 0.8);
    let full = BondedSolid {
        hardening: Some(Hardening { yield_stress: 200e6, hardening: 400e6, exponent: 0.45 }),
        dust: 0.5,
        failure: Some(DuctileFailure { d: [0.1, 0.5, -1.5, 0.0, 0.0] }),
        max_plastic_stretch: Some(0.15),
        grain: Some(BondGrain { axis, strength: 2.0, stretch: 0.8 }),
        ..BondedSolid::default()
    };
    let bonded = |bonds: BondedSolid| {
        let mut job = sample();
        let material = *law(&mut job).0;
        job.problem.law = Law::Bonded { material, bonds };
        job
    };
    let other = [
        full,
        BondedSolid::default(),
        BondedSolid { hardening: None, ..full },
        BondedSolid { breaks: false, ..full },
        BondedSolid { dust: 0.6, ..full },
        BondedSolid { failure: None, ..full },
        BondedSolid { max_plastic_stretch: None, ..full },
        BondedSolid { grain: None, ..full },
        BondedSolid { friction: 0.4, ..full },
        BondedSolid { bond_damping: 0.2, ..full },
        BondedSolid { air_damping: 1.0, ..full },
        BondedSolid { horizon: 2.04, ..full },
    ];
    let mut ids = vec![sample().id()?];
    for bonds in other {
        let job = bonded(bonds);
        let bytes = job.encode()?;
        assert_eq!(FractureJob::decode(&bytes)?, job);
        assert!(!ids.contains(&job.id()?), "{bonds:?}");
        ids.push(job.id()?);
        for end in 0..bytes.len() {
            assert!(FractureJob::decode(&bytes[..end]).is_err(), "{end} of {}", bytes.len());
        }
    }
    assert_eq!(ids[1].short(), "37810cbf");
    for wrong in [
        BondedSolid { dust: f64::NAN, ..full },
        BondedSolid { horizon: f64::INFINITY, ..full },
        BondedSolid { max_plastic_stretch: Some(f64::NAN), ..full },
        BondedSolid {
            grain: Some(BondGrain { axis: axis * f64::NAN, strength: 1.0, stretch: 1.0 }),
            ..full
        },
        BondedSolid { failure: Some(DuctileFailure { d: [0.1, 0.5, f64::NAN, 0.0, 0.0] }), ..full },
    ] {
        let found = bonded(wrong).encode();
        assert_eq!(found, Err(WireError::NotFinite { what: "a job's bonds" }));
    }
    Ok(())
}

/// Whatever a header holds in place of its bytes, it is read or refused, and never more.
#[test]
fn hostile_bytes_of_a_job_of_bonds_are_refused_or_read() -> Result<(), WireError> {
    let mut job = sample();
    let material = *law(&mut job).0;
    job.problem.law = Law::Bonded { material, bonds: BondedSolid::default() };
    let bytes = job.encode()?;
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    for at in envelope::PREFIX..envelope::PREFIX + length {
        for value in [0, 1, 2, 0x7f, 0xfe, 0xff] {
            let mut hostile = bytes.clone();
            hostile[at] = value;
            let sum = crc32c::crc32c(&hostile[envelope::PREFIX..envelope::PREFIX + length]);
            hostile[16..20].copy_from_slice(&sum.to_le_bytes());
            if let Ok(read) = FractureJob::decode(&hostile) {
                assert!(read.encode().is_ok(), "byte {at} as {value}");
            }
        }
    }
    // As another kind of job it is none.
    for kind in [MessageKind::Job, MessageKind::TreatedJob, MessageKind::YieldingJob] {
        let mut other = bytes.clone();
        other[8..10].copy_from_slice(&(kind as u16).to_le_bytes());
        assert!(FractureJob::decode(&other).is_err(), "{kind:?}");
    }
    Ok(())
}

#[test]
fn any_change_of_the_problem_changes_its_id() -> Result<(), WireError> {
    let change: [fn(&mut FractureJob); 23] = [
        |j| j.problem.settings.brittle.hairline = None,
        |j| j.problem.settings.error = None,
        |j| j.problem.settings.brittle.detail.height = 0.2,
        |j| j.problem.seed += 1,
        |j| j.solver.push('x'),
        |j| j.fallback = None,
        |j| law(j).0.young *= 1.0 + f64::EPSILON,
        |j| law(j).1.seed += 1,
        |j| surface(j).hardness += 1.0,
        |j| surface(j).friction = 0.8,
        |j| law(j).1.offset[0] = 1e-9,
        |j| law(j).1.strokes[3].edge = 1e-9,
        |j| paint(j).factors[1] = 0.9,
        |j| j.problem.impacts[0].energy += 1.0,
        |j| j.problem.impacts[0].closing_speed += 1.0,
        |j| j.problem.impacts[0].crushing_pressure += 1.0,
        |j| j.problem.settings.spacing = Some(0.1),
        |j| j.problem.settings.grain = None,
        |j| j.problem.settings.precision = PointPrecision::Single,
        |j| j.problem.supports[0].radius = 0.03,
        |j| j.problem.spin.x = 1.0,
        |j| solid(j).mesh.vertices[0].x = 1e-300,
        |j| solid(j).surface[0] = Surface::crack(0.0),
    ];
    for (index, change) in change.iter().enumerate() {
        let mut other = sample();
        change(&mut other);
        assert_ne!(other.id()?, sample().id()?, "change {index}");
    }
    Ok(())
}

#[test]
fn nonsense_is_refused_with_its_bound() {
    let refused = |change: fn(&mut FractureJob)| {
        let mut job = sample();
        change(&mut job);
        job.encode().err()
    };
    let nan = refused(|j| law(j).0.young = f64::NAN);
    assert_eq!(nan, Some(WireError::NotFinite { what: "a job's material" }));
    let strength = refused(|j| law(j).1.strokes[1].factor = f64::NAN);
    assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
    let strength = refused(|j| law(j).1.offset[1] = f64::NAN);
    assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
    let short = refused(|j| paint(j).factors.clear());
    assert!(matches!(short, Some(WireError::Short { have: 0, need: 2, .. })));
    let support = refused(|j| j.problem.supports[0].point[2] = f64::NAN);
    assert_eq!(support, Some(WireError::NotFinite { what: "a job's supports" }));
    let many = refused(|j| j.problem.supports = vec![j.problem.supports[0]; MAX_SUPPORTS + 1]);
    assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
    let many = refused(|j| j.problem.impacts = vec![j.problem.impacts[0]; MAX_IMPACTS + 1]);
    assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
    let tags = refused(|j| solid(j).surface.clear());
    assert!(matches!(tags, Some(WireError::Short { .. })));
    let mut far = sample();
    solid(&mut far).mesh.triangles[2][1] = 4;
    let far = far.encode().and_then(|bytes| FractureJob::decode(&bytes));
    assert_eq!(far, Err(WireError::Index { triangle: 2, index: 4, vertices: 4 }));
    let mut early = sample();
    solid(&mut early).surface[3] = Surface::crack(f32::NAN);
    let early = early.encode().and_then(|bytes| FractureJob::decode(&bytes));
    assert!(matches!(early, Err(WireError::Mark { index: 0, .. })));
    let mut lost = sample();
    solid(&mut lost).mesh.vertices[1].y = f64::INFINITY;
    let lost = lost.encode().and_then(|bytes| FractureJob::decode(&bytes));
    assert_eq!(lost, Err(WireError::NotFinite { what: "a mesh's vertices" }));
}
