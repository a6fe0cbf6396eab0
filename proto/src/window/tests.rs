use super::*;
use crate::Verdict;
use crate::outline::{Outline, Parted};
use cullet_geometry::{Mat3, Pose, shapes};
use cullet_model::{
    BodyCut, BodyGrip, BodyRegion, BondedSolid, Figure, FurtherQuantities, Handed, Material,
    MembranePace, MovingSurface, Proxy, SettledPiece, SheetAir, SheetDiffusion, SheetRegion,
    SheetSource, SheetSourceKind, SoftBody, SoftLaw, SurfaceFrame, SweptExtent, TornPiece,
    WindowLedger, WindowOutcome,
};

fn proxy(body: u64, motion: ProxyMotion) -> Proxy {
    let corners: Vec<Vec3> = (0..200).map(|k| Vec3::new(f64::from(k), 1.0, 2.0)).collect();
    Proxy {
        body,
        object: None,
        parts: vec![corners.clone(), corners[..4].to_vec()],
        friction: 0.5,
        pose: Pose::new(Vec3::x(), Vec3::new(0.1, 0.2, 0.3)),
        velocity: Vec3::y(),
        spin: Vec3::z(),
        motion,
    }
}

fn job() -> WindowJob {
    let mut job = WindowJob::smallest("membrane", 7);
    let free = ProxyMotion::Free { mass: 2.0, inertia: Mat3::identity() };
    let led = ProxyMotion::Led(vec![Pose::identity(); 4]);
    job.window.retired = Some(vec![2, 5]);
    job.window.proxies = vec![proxy(3, free), proxy(5, ProxyMotion::Steady), proxy(9, led)];
    job.state = Some(Arc::new((0..9_000u32).map(|k| k as u8).collect()));
    job
}

#[test]
fn a_window_comes_back_from_its_parts_with_the_id_of_the_whole() -> Result<(), WireError> {
    let job = job();
    assert_eq!(WindowJob::decode(&job.encode()?)?, job);
    let parted = Parted::of_window(&job)?;
    // The body itself is small and stays in the outline.
    assert_eq!((parted.parts.len(), parted.id), (2, job.id()?));
    let parts: Vec<_> = parted.parts.iter().map(|(_, part)| part.as_slice()).collect();
    assert_eq!(Outline::open(&parted.outline)?.whole(&parts), Some(job.encode()?));
    // The part that is the state has the state's own digest: who made it has it already.
    let state = job.state.as_ref().expect("a state");
    assert_eq!(parted.parts[1].0, digest(state));
    let start = WindowJob { state: None, ..job.clone() };
    assert_eq!(WindowJob::decode(&start.encode()?)?, start);
    let empty = WindowJob { state: Some(Arc::default()), ..job.clone() };
    assert_ne!(empty.id()?, start.id()?);
    assert_eq!(empty.setup_digest()?, job.setup_digest()?);
    assert_ne!(WindowJob::smallest("membrane", 8).setup_digest()?, job.setup_digest()?);
    Ok(())
}

/// A soft body with a solid of some hundred triangles.
fn soft() -> Result<WindowJob, WireError> {
    let mut job = job();
    let detail = shapes::Detail { segments: 200, ..shapes::Detail::default() };
    let mesh = shapes::cylinder(0.1, 0.1, detail).expect("a cylinder");
    let region = BodyRegion::Ball { centre: Vec3::x(), radius: 0.1 };
    let path: Vec<(f64, Vec3)> = (0..3000).map(|k| (f64::from(k), Vec3::y())).collect();
    job.setup.body = ContinuumBody::Soft(SoftBody {
        solid: Arc::new(Solid::outer(mesh)),
        material: Material {
            density: 1000.0,
            young: 1e5,
            poisson: 0.3,
            failure_stress: 1e4,
            fracture_energy: 10.0,
        },
        law: SoftLaw::Bonded(BondedSolid::default()),
        spacing: 0.01,
        damping: 0.1,
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        grips: vec![BodyGrip { region, path, turn: Vec3::z(), until: None }],
        cuts: vec![BodyCut { corners: vec![Vec3::x(), Vec3::y(), Vec3::z()] }],
        air: SheetAir {
            density: 0.0,
            drag: 0.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        pace: MembranePace::Real,
    });
    Ok(job)
}

#[test]
fn a_soft_body_travels_with_its_solid_and_by_one_digest() -> Result<(), WireError> {
    let job = soft()?;
    assert_eq!(WindowJob::decode(&job.encode()?)?, job);
    let parted = Parted::of_window(&job)?;
    assert_eq!(parted.parts.len(), 3);
    let mut later = job.clone();
    later.window.first_step += 4;
    assert_eq!(Parted::of_window(&later)?.parts[0], parted.parts[0]);
    let mut other = job.clone();
    let ContinuumBody::Soft(body) = &mut other.setup.body else { panic!("another body") };
    Arc::make_mut(&mut body.solid).mesh.vertices[0].x += 1e-9;
    assert_ne!(other.setup_digest()?, job.setup_digest()?);
    assert_eq!(later.setup_digest()?, job.setup_digest()?);
    Ok(())
}

#[test]
fn what_no_window_is_is_refused_with_its_bound() -> Result<(), WireError> {
    let bytes = job().encode()?;
    assert!(WindowJob::is(&bytes) && !crate::specimen::SpecimenJob::is(&bytes));
    let short = WindowJob::decode(&bytes[..bytes.len() - 1]);
    assert!(matches!(short, Err(WireError::Short { what: "a window's state", .. })), "{short:?}");
    let long = WindowJob::decode(&[bytes, vec![0]].concat());
    assert!(matches!(long, Err(WireError::Trailing { .. })), "{long:?}");
    let spoilt = |spoil: &dyn Fn(&mut WindowJob)| {
        let mut job = job();
        spoil(&mut job);
        job.encode().map(drop)
    };
    let limit = |said: &Result<(), WireError>| matches!(said, Err(WireError::Limit { .. }));
    assert!(limit(&spoilt(&|job| job.window.steps = 0)));
    assert!(limit(&spoilt(&|job| job.window.frame_every = 0)));
    assert!(limit(&spoilt(&|job| job.window.steps = 2_000)));
    let many = vec![proxy(1, ProxyMotion::Steady); MAX_PROXIES + 1];
    assert!(limit(&spoilt(&|job| job.window.proxies.clone_from(&many))));
    let nan = spoilt(&|job| job.window.proxies[0].velocity.x = f64::NAN);
    assert!(matches!(nan, Err(WireError::NotFinite { .. })), "{nan:?}");
    let led = spoilt(&|job| job.window.steps = 5);
    assert!(matches!(led, Err(WireError::Short { what: "poses of a led body", .. })), "{led:?}");
    let turn = spoilt(&|job| job.window.proxies[0].pose.rotation.as_mut_unchecked().coords *= 2.0);
    assert!(matches!(turn, Err(WireError::Header(_))), "{turn:?}");
    Ok(())
}

/// A sheet with several quantities.
fn soaking() -> WindowJob {
    let mut job = job();
    let ContinuumBody::Membrane(sheet) = &mut job.setup.body else { panic!("another body") };
    let what = |start: f64| SheetDiffusion {
        capacity: 1.0,
        conductivity: [1e-5; 2],
        expansion: [0.0; 2],
        start,
        saturation: 1.0,
        stiffness: vec![(0.0, 1.0), (1.0, 0.5)],
        toughness: vec![],
        strength: vec![],
        exposure: 0.0,
        weight: 0.0,
        loss: 0.0,
        ambient: 0.0,
        sources: vec![],
    };
    sheet.diffusion = Some(what(0.25)).into();
    sheet.diffusion.all.push(what(0.5));
    sheet.diffusion.names = vec!["heat".into(), "water".into()];
    sheet.diffusion.shown = 1;
    job
}

/// What there is beside a first quantity stands behind the body's numbers; a body without more has
/// the bytes that it had before there could be.
#[test]
fn several_quantities_travel_behind_the_first() -> Result<(), WireError> {
    let several = soaking();
    assert_eq!(WindowJob::decode(&several.encode()?)?, several);
    let numbers = |job: &WindowJob| job.body().map(|(slab, ..)| slab);
    let mut one = several.clone();
    let ContinuumBody::Membrane(sheet) = &mut one.setup.body else { panic!("another body") };
    sheet.diffusion = sheet.diffusion.all.first().cloned().into();
    let plain = numbers(&one)?;
    assert_eq!(numbers(&several)?[..plain.len()], plain);
    assert_eq!(plain, codec::encode_record(&one.setup)?);
    assert_ne!(several.setup_digest()?, one.setup_digest()?);
    let shown = |shown| {
        let mut job = several.clone();
        let ContinuumBody::Membrane(sheet) = &mut job.setup.body else { panic!("another body") };
        sheet.diffusion.shown = shown;
        job.setup_digest()
    };
    assert_ne!(shown(0)?, shown(1)?);
    // Behind nothing, or with something behind it, it is not what anyone wrote.
    let bytes = [plain, codec::encode_record(&FurtherQuantities::default())?].concat();
    assert!(matches!(setup_of(&bytes), Err(WireError::Header(_))), "{:?}", setup_of(&bytes));
    let bytes = [numbers(&several)?, vec![0]].concat();
    assert!(matches!(setup_of(&bytes), Err(WireError::Trailing { .. })));
    Ok(())
}

/// Which object a body in reach is travels where the sheet takes something up by contact.
#[test]
fn objects_travel_where_a_sheet_asks_for_them() -> Result<(), WireError> {
    let mut job = soaking();
    for (proxy, object) in job.window.proxies.iter_mut().zip([Some(4), None, Some(0)]) {
        proxy.object = object;
    }
    let forgotten = WindowJob::decode(&job.encode()?)?;
    assert!(forgotten.window.proxies.iter().all(|proxy| proxy.object.is_none()));
    assert_eq!(forgotten.id()?, job.id()?);
    let ContinuumBody::Membrane(sheet) = &mut job.setup.body else { panic!("another body") };
    sheet.diffusion.all[1].sources.push(SheetSource {
        region: SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] },
        from: 0.0,
        until: 1.0,
        kind: SheetSourceKind::Contact { object: 4, towards: 1.0, film: 1e-3 },
    });
    assert_eq!(WindowJob::decode(&job.encode()?)?, job);
    let mut other = job.clone();
    other.window.proxies[1].object = Some(4);
    assert_ne!(other.id()?, job.id()?);
    let parted = Parted::of_window(&job)?;
    let parts: Vec<_> = parted.parts.iter().map(|(_, part)| part.as_slice()).collect();
    assert_eq!(Outline::open(&parted.outline)?.whole(&parts), Some(job.encode()?));
    Ok(())
}

fn outcome() -> WindowOutcome {
    let handed = |body| Handed {
        body,
        impulses: vec![[Vec3::x(), Vec3::y()], [Vec3::z(), Vec3::zeros()]],
        poses: vec![Pose::new(Vec3::y(), Vec3::new(0.3, 0.1, -0.2)); 2],
    };
    let surface = MovingSurface {
        triangles: vec![[0, 1, 2]],
        reference: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        thickness: 0.5,
    };
    let frame = |step, quantity| SurfaceFrame {
        step,
        surface: 0,
        origin: Vec3::x(),
        offsets: vec![[0.0, 1.0, 2.0]; 3],
        quantity,
    };
    let piece =
        TornPiece { number: 1, parent: 0, born: 1 << 40, mass: 0.1, area: 0.2, frozen: true };
    WindowOutcome {
        state: vec![1, 2, 3],
        extent: SweptExtent { low: [-1.0; 3], high: [1.0; 3], speed: 2.0, spacing: 0.1 },
        handed: vec![handed(3), handed(5)],
        surfaces: vec![surface],
        frames: vec![frame(4, Vec::new()), frame(8, vec![0.5; 3])],
        pieces: vec![TornPiece { frozen: false, ..piece }, piece],
        settled: vec![SettledPiece {
            number: 1,
            solid: Arc::new(crate::job::tests::tetrahedron()),
            place: Vec3::z(),
            mass: 0.1,
        }],
        ledger: WindowLedger { mass: 1.0, residual: -1e-9, ..WindowLedger::default() },
        figures: vec![Figure { name: "pace".into(), unit: "1".into(), value: 2.0 }],
        warnings: vec!["look".into()],
    }
}

#[test]
fn an_outcome_comes_back_as_it_went_or_says_what_is_wrong() -> Result<(), WireError> {
    let outcome = outcome();
    let bytes = Verdict::Moved(Box::new(outcome.clone())).encode()?;
    assert_eq!(Verdict::decode(&bytes)?, Verdict::Moved(Box::new(outcome.clone())));
    assert_eq!(state_of(&bytes), Some(&[1, 2, 3][..]));
    assert_eq!(state_of(&job().encode()?), None);
    let short = decode_outcome(&bytes[..bytes.len() - 1]);
    let what = "a mesh's front speeds";
    assert!(matches!(short, Err(WireError::Short { what: said, .. }) if said == what), "{short:?}");
    let spoilt = |spoil: &dyn Fn(&mut WindowOutcome)| {
        let mut outcome = outcome.clone();
        spoil(&mut outcome);
        encode_outcome(&outcome).and_then(|bytes| decode_outcome(&bytes).map(drop))
    };
    assert!(matches!(spoilt(&|o| o.surfaces[0].triangles[0][1] = 3), Err(WireError::Index { .. })));
    assert!(matches!(spoilt(&|o| o.frames[0].surface = 1), Err(WireError::Short { .. })));
    assert!(matches!(spoilt(&|o| o.frames[1].quantity = vec![1.0]), Err(WireError::Short { .. })));
    let spoils: [fn(&mut WindowOutcome); 7] = [
        |o| o.settled[0].mass = f64::NAN,
        |o| o.extent.speed = f64::NAN,
        |o| o.handed[0].poses[1].translation.vector.z = f64::NAN,
        |o| o.frames[0].offsets[1][2] = f32::NAN,
        |o| o.ledger.torn_area = f64::INFINITY,
        |o| o.pieces[1].area = f64::NAN,
        |o| o.handed[1].impulses[0][0].x = f64::NAN,
    ];
    for spoil in spoils {
        assert!(matches!(spoilt(&spoil), Err(WireError::NotFinite { .. })));
    }
    Ok(())
}
