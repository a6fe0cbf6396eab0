//! Soft shells that move: `cargo run --release -p cullet-shell --example soft -- CASE [FOLDER]`.
//!
//! Runs one of the cases for some tenths of a second, prints the ledger and how many seconds a
//! second of film takes, and writes its last frames as OBJ files into the folder.

use cullet_geometry::shapes::{Detail, cuboid, sphere};
use cullet_geometry::{Mat3, Pose, Solid, TriMesh, Vec3};
use cullet_model::{
    BodyCut, BodyGrip, BodyRegion, Continuum, ContinuumBody, ContinuumSetup, Hardening, Material,
    MembranePace, Proxy, ProxyMotion, SheetAir, SoftBody, SoftLaw, Window, WindowOutcome,
    WindowProgress,
};
use cullet_shell::SoftShellWindow;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Step of the world \[s\], steps of a window, steps between frames.
const WORLD_STEP: f64 = 1.0 / 240.0;
const WINDOW: u32 = 12;
const FRAME: u32 = 12;

/// A body and what meets it.
struct SoftCase {
    body: SoftBody,
    gravity: Vec3,
    proxies: Vec<Proxy>,
    /// \[s\].
    duration: f64,
}

fn box_mesh(size: [f64; 3]) -> TriMesh {
    cuboid(Vec3::from(size), Detail::default()).expect("a box")
}

fn soft(mesh: TriMesh, material: Material, law: SoftLaw, spacing: f64) -> SoftBody {
    SoftBody {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        law,
        spacing,
        damping: 0.05,
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        grips: vec![],
        cuts: vec![],
        air: SheetAir {
            density: 1.2,
            drag: 1.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        pace: MembranePace::Real,
    }
}

const WHOLE: SoftLaw = SoftLaw::Shell { hardening: None, breaks: false };
const TEARS: SoftLaw = SoftLaw::Shell { hardening: None, breaks: true };

fn matter(density: f64, young: f64, stress: f64, energy: f64) -> Material {
    Material { density, young, poisson: 0.3, failure_stress: stress, fracture_energy: energy }
}

fn ball(radius: f64, motion: ProxyMotion, place: Vec3, velocity: Vec3) -> Proxy {
    let parts = vec![sphere(radius, Detail::default()).expect("a ball").vertices];
    let pose = Pose::from_parts(place.into(), cullet_geometry::Quat::identity());
    Proxy { body: 7, parts, friction: 0.3, pose, velocity, spin: Vec3::zeros(), motion }
}

fn free_ball(radius: f64, density: f64, place: Vec3, velocity: Vec3) -> Proxy {
    let mass = 4.19 * radius * radius * radius * density;
    let inertia = Mat3::identity() * (0.4 * mass * radius * radius);
    ball(radius, ProxyMotion::Free { mass, inertia }, place, velocity)
}

fn slab(body: u64, half: [f64; 3], place: Vec3, velocity: Vec3) -> Proxy {
    let side = |k: usize, axis: usize| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] };
    let corners = (0..8).map(|k| Vec3::new(side(k, 0), side(k, 1), side(k, 2))).collect();
    let pose = Pose::from_parts(place.into(), cullet_geometry::Quat::identity());
    Proxy {
        body,
        parts: vec![corners],
        friction: 0.5,
        pose,
        velocity,
        spin: Vec3::zeros(),
        motion: ProxyMotion::Steady,
    }
}

fn grip(low: [f64; 3], high: [f64; 3], path: Vec<(f64, Vec3)>) -> BodyGrip {
    let region = BodyRegion::Box { low: Vec3::from(low), high: Vec3::from(high) };
    BodyGrip { region, path, turn: Vec3::zeros(), until: None }
}

/// The wall between two curves that are swept up: a closed mesh from a polyline of the midline.
fn swept(line: &[[f64; 2]], is_ring: bool, thickness: f64, height: f64) -> TriMesh {
    let count = line.len();
    let rows = 40;
    let mut vertices = Vec::new();
    for j in 0..=rows {
        let z = height * (j as f64 / rows as f64 - 0.5);
        vertices.extend(line.iter().map(|&[x, y]| Vec3::new(x, y, z)));
    }
    let mut triangles = Vec::new();
    let last = if is_ring { count } else { count - 1 };
    for j in 0..rows {
        for i in 0..last {
            let at = |i: usize, j: usize| (j * count + i % count) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let t = vec![thickness; vertices.len()];
    cullet_geometry::midsurface::thicken(&vertices, &triangles, &t).expect("a wall")
}

fn ring(radius: [f64; 2], count: usize) -> Vec<[f64; 2]> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
    (0..count).map(|k| [radius[0] * angle(k).cos(), radius[1] * angle(k).sin()]).collect()
}

fn notch(from: f64, to: f64) -> BodyCut {
    let corner = |x: f64, z: f64| Vec3::new(x, 1e-5, z);
    BodyCut {
        corners: vec![corner(from, -0.1), corner(to, -0.1), corner(to, 0.1), corner(from, 0.1)],
    }
}

const DOWN: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// A cloth of 0.5 m that falls on a ball.
fn cloth() -> SoftCase {
    let mut body = soft(box_mesh([0.5, 0.5, 2e-3]), matter(500.0, 1e5, 1e5, 100.0), WHOLE, 0.01);
    body.pose.translation.vector.z = 0.13;
    body.damping = 0.2;
    let proxies = vec![ball(0.12, ProxyMotion::Steady, Vec3::zeros(), Vec3::zeros())];
    SoftCase { body, gravity: DOWN, proxies, duration: 0.5 }
}

/// A tube that a plate presses together from above.
fn cylinder() -> SoftCase {
    let mesh = swept(&ring([0.1, 0.1], 96), true, 4e-3, 0.4);
    let body = soft(mesh, matter(1000.0, 4.2e5, 1e5, 100.0), WHOLE, 0.012);
    let down = Vec3::new(0.0, 0.0, -0.4);
    let proxies = vec![
        slab(1, [0.3, 0.3, 0.05], Vec3::new(0.0, 0.0, -0.252), Vec3::zeros()),
        slab(2, [0.3, 0.3, 0.05], Vec3::new(0.0, 0.0, 0.252), down),
    ];
    SoftCase { body, gravity: Vec3::zeros(), proxies, duration: 0.4 }
}

/// A sheet with a notch at one side, pulled apart.
fn rubber() -> SoftCase {
    let mesh = box_mesh([0.4, 0.4, 4e-3]);
    let mut body = soft(mesh, matter(1000.0, 3.2e5, 8e4, 300.0), TEARS, 0.01);
    let pull = |way: f64| vec![(1.0, Vec3::new(0.0, way, 0.0))];
    body.grips = vec![
        grip([-0.3, 0.18, -0.1], [0.3, 0.3, 0.1], pull(0.05)),
        grip([-0.3, -0.3, -0.1], [0.3, -0.18, 0.1], pull(-0.05)),
    ];
    body.cuts = vec![notch(-0.3, -0.1)];
    SoftCase { body, gravity: Vec3::zeros(), proxies: vec![], duration: 0.7 }
}

/// A garment's trunk: a tube of cloth with a short cut, held at the top and blown up until it
/// tears on from there.
fn garment() -> SoftCase {
    let mesh = swept(&ring([0.14, 0.1], 96), true, 2e-3, 0.4);
    let mut body = soft(mesh, matter(200.0, 3.2e4, 5e3, 8.0), TEARS, 0.012);
    body.grips = vec![grip([-0.3, -0.3, 0.18], [0.3, 0.3, 0.3], vec![])];
    body.air.pressure = 20.0;
    let corner = |x: f64, z: f64| Vec3::new(x, 1e-5, z);
    let corners =
        vec![corner(0.1, -0.06), corner(0.2, -0.06), corner(0.2, 0.04), corner(0.1, 0.04)];
    body.cuts = vec![BodyCut { corners }];
    SoftCase { body, gravity: DOWN, proxies: vec![], duration: 0.4 }
}

/// A sheet of soft metal that a ball goes through.
fn metal() -> SoftCase {
    let flow = Hardening { yield_stress: 4e5, hardening: 1.5e6, exponent: 0.5 };
    let law = SoftLaw::Shell { hardening: Some(flow), breaks: true };
    let mesh = box_mesh([0.3, 0.3, 3e-3]);
    let mut body = soft(mesh, matter(2000.0, 2e7, 9e5, 400.0), law, 7.5e-3);
    body.grips = vec![
        grip([-0.2, 0.14, -0.1], [0.2, 0.2, 0.1], vec![]),
        grip([-0.2, -0.2, -0.1], [0.2, -0.14, 0.1], vec![]),
        grip([-0.2, -0.2, -0.1], [-0.14, 0.2, 0.1], vec![]),
        grip([0.14, -0.2, -0.1], [0.2, 0.2, 0.1], vec![]),
    ];
    let start = Vec3::new(0.003, 0.002, 0.05);
    let proxies = vec![free_ball(0.03, 7800.0, start, Vec3::new(0.0, 0.0, -9.0))];
    SoftCase { body, gravity: DOWN, proxies, duration: 0.05 }
}

/// A strip that is rolled up, let go.
fn spiral() -> SoftCase {
    let turns = 2.25;
    let at = |k: usize| {
        let share = k as f64 / 400.0;
        let angle = std::f64::consts::TAU * turns * share;
        let radius = 0.06 + 0.10 * share;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let line: Vec<[f64; 2]> = (0..=400).map(at).collect();
    let mesh = swept(&line, false, 4e-3, 0.2);
    let mut body = soft(mesh, matter(1000.0, 3.2e5, 8e4, 300.0), WHOLE, 0.01);
    body.grips = vec![grip([0.055, -0.02, -0.2], [0.07, 0.012, 0.2], vec![])];
    SoftCase { body, gravity: Vec3::new(0.0, -9.81, 0.0), proxies: vec![], duration: 0.4 }
}

fn case(name: &str) -> SoftCase {
    match name {
        "cloth" => cloth(),
        "cylinder" => cylinder(),
        "rubber" => rubber(),
        "garment" => garment(),
        "metal" => metal(),
        "spiral" => spiral(),
        other => panic!("no case {other}: cloth, cylinder, rubber, garment, metal, spiral"),
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "cloth".to_owned());
    let folder = arguments.next();
    let SoftCase { body, gravity, mut proxies, duration } = case(&name);
    let setup = ContinuumSetup {
        body: ContinuumBody::Soft(body),
        world_step: WORLD_STEP,
        gravity,
        seed: 1,
    };
    let begun = Instant::now();
    let prepared = Arc::new(SoftShellWindow::prepare(&setup).expect("a soft shell"));
    println!("{name}: prepared in {:.2} s", begun.elapsed().as_secs_f64());
    let begun = Instant::now();
    let (mut state, mut step) = (None::<Vec<u8>>, 0);
    let windows = (duration / (WORLD_STEP * f64::from(WINDOW))).ceil() as u32;
    for _ in 0..windows {
        let window = Window {
            first_step: step,
            steps: WINDOW,
            frame_every: FRAME,
            proxies: proxies.clone(),
            retired: None,
        };
        let outcome = solve(&prepared, state.as_deref(), window);
        step += u64::from(WINDOW);
        follow(&mut proxies, &outcome);
        print(&outcome, step);
        if let Some(folder) = &folder {
            draw(&outcome, &Path::new(folder).join(format!("{name}-{step}.obj")));
        }
        state = Some(outcome.state);
    }
    let (took, film) = (begun.elapsed().as_secs_f64(), step as f64 * WORLD_STEP);
    println!("{name}: {took:.2} s for {film:.3} s of film: {:.1} s a second", took / film);
}

fn solve(
    prepared: &Arc<<SoftShellWindow as Continuum>::Prepared>,
    state: Option<&[u8]>,
    window: Window,
) -> WindowOutcome {
    let mut solve = SoftShellWindow::open(Arc::clone(prepared), state, window).expect("a window");
    loop {
        match solve.advance() {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(outcome) => return *outcome,
            WindowProgress::Failed(failure) => panic!("{failure:?}"),
        }
    }
}

/// Lets bodies go on from where a window left them.
fn follow(proxies: &mut [Proxy], outcome: &WindowOutcome) {
    for (proxy, handed) in proxies.iter_mut().zip(&outcome.handed) {
        let poses = &handed.poses;
        let (last, before) = (poses[poses.len() - 1], poses[poses.len() - 2]);
        proxy.pose = last;
        if matches!(proxy.motion, ProxyMotion::Free { .. }) {
            proxy.velocity = (last.translation.vector - before.translation.vector) / WORLD_STEP;
            let turn = (last.rotation * before.rotation.inverse()).scaled_axis();
            proxy.spin = turn / WORLD_STEP;
        }
    }
}

fn print(outcome: &WindowOutcome, step: u64) {
    let ledger = &outcome.ledger;
    let figure =
        |name: &str| outcome.figures.iter().find(|f| f.name == name).map_or(f64::NAN, |f| f.value);
    println!(
        "{step:5}: K {:.3e} S {:.3e} B {:.3e} broken {:.2e} plastic {:.2e} damped {:.2e} \
         air {:.2e} grips {:.2e} gravity {:.2e} bodies {:.2e} residual {:.1e} J; torn {:.2e} m2, \
         {} pieces, {} control points, {} steps, {:.1} x stiff",
        ledger.kinetic,
        ledger.stretching,
        ledger.bending,
        ledger.broken,
        ledger.plastic,
        ledger.damped,
        ledger.air,
        ledger.grips,
        ledger.gravity,
        ledger.bodies,
        ledger.residual,
        ledger.torn_area,
        outcome.pieces.len(),
        figure("control_points"),
        figure("steps"),
        figure("stiffest"),
    );
    outcome.warnings.iter().for_each(|warning| println!("       {warning}"));
}

fn draw(outcome: &WindowOutcome, path: &Path) {
    let Some(frame) = outcome.frames.last() else { return };
    let mut file = std::fs::File::create(path).expect("the folder can be written to");
    let mut text = String::new();
    for offset in &frame.offsets {
        let x = frame.origin + Vec3::from(offset.map(f64::from));
        text += &format!("v {:.6} {:.6} {:.6}\n", x.x, x.y, x.z);
    }
    for [a, b, c] in &outcome.surfaces[frame.surface as usize].triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    file.write_all(text.as_bytes()).expect("the file can be written");
}
