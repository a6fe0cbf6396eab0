//! One field, CPIC and ours on the cube of the thesis's Fig. 3.17 to 3.19.

use super::specimen::{Now, STONE, Specimen};
use super::twin::{Coupling, Twin};
use cullet_fracture::mpm::Domain;
use cullet_fracture::mpm::domain::{PointMotion, VelocityFields};
use cullet_fracture::particles::Particles;
use cullet_geometry::Vec3;
use rayon::prelude::*;
use wide::f64x4;

/// Half the edge of the cube, in spacings.
const HALF: f64 = 6.0;
const WAY: Vec3 = Vec3::new(0.0, 0.01, 0.0);
/// Steps of the pull, and of the rest after it.
const PULL: u64 = 480;
const REST: u64 = 200;
/// Steps between looks.
const LOOK: usize = 4;
/// What a step of the rest leaves of velocities \[1\].
const FADE: f64 = 0.9;

/// What the solver and its twin have in common.
trait Body {
    /// Takes one step; the energy that went into damage \[J\].
    fn advance(&mut self) -> f64;
    fn points(&self) -> (&Particles, Vec<PointMotion>);
    /// The grips hold still from then on.
    fn hold(&mut self, specimen: &Specimen);
    /// Takes a share of all velocities.
    fn damp(&mut self);
}

impl Body for Domain {
    fn advance(&mut self) -> f64 {
        Domain::advance(self).dissipated
    }

    fn points(&self) -> (&Particles, Vec<PointMotion>) {
        (&self.particles, self.motions())
    }

    fn hold(&mut self, specimen: &Specimen) {
        self.prescribed = Some(specimen.grip(Vec3::zeros()));
    }

    fn damp(&mut self) {
        self.grid.nodes.velocity.iter_mut().for_each(|v| *v *= f64x4::splat(FADE));
    }
}

impl Body for Twin {
    fn advance(&mut self) -> f64 {
        Twin::advance(self)
    }

    fn points(&self) -> (&Particles, Vec<PointMotion>) {
        (&self.particles, self.motions())
    }

    fn hold(&mut self, specimen: &Specimen) {
        self.grip = Some(specimen.grip(Vec3::zeros()));
    }

    fn damp(&mut self) {
        Twin::damp(self, FADE);
    }
}

/// What became of a cube.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    /// Layers of broken points ahead of the front.
    layers: f64,
    /// Steps until a point broke in every column of the section; 0 for never.
    cut: f64,
    /// Steps until the pull first fell under a twentieth of its greatest; 0 for never.
    slack: f64,
    /// Energy that went into damage over G_f times the section \[1\].
    spent: f64,
    /// Means over the last quarter of the pull \[J\].
    elastic: f64,
    kinetic: f64,
    /// What is still held when all has come to rest \[J\].
    welded: f64,
    /// What the section still bears then over its greatest pull \[1\].
    borne: f64,
}

impl Course {
    fn values(&self) -> [f64; 8] {
        let Self { layers, cut, slack, spent, elastic, kinetic, welded, borne } = *self;
        [layers, cut, slack, spent, 1e3 * elastic, 1e3 * kinetic, 1e3 * welded, borne]
    }
}

fn now(specimen: &Specimen, body: &dyn Body) -> Now {
    let (particles, motions) = body.points();
    specimen.now(particles, &motions)
}

fn run(specimen: &Specimen, body: &mut dyn Body) -> Course {
    let (mut course, mut states) = (Course::default(), Vec::new());
    for step in 1..=PULL {
        course.spent += body.advance() / (STONE.fracture_energy * specimen.section());
        if step.is_multiple_of(LOOK as u64) {
            states.push(now(specimen, body));
            if course.cut == 0.0 && specimen.is_cut(&specimen.broken(body.points().0)) {
                course.cut = step as f64;
            }
        }
    }
    let late = &states[states.len() * 3 / 4..];
    course.elastic = late.iter().map(|s| s.elastic).sum::<f64>() / late.len() as f64;
    course.kinetic = late.iter().map(|s| s.kinetic).sum::<f64>() / late.len() as f64;
    course.layers = specimen.layers(&specimen.broken(body.points().0));
    // Over a wave's way through the cube, 20 steps.
    let pulls: Vec<f64> =
        states.windows(5).map(|w| w.iter().map(|s| s.pull).sum::<f64>() / 5.0).collect();
    let peak = pulls.iter().fold(0.0_f64, |m, x| m.max(*x));
    let top = pulls.iter().position(|x| *x == peak).unwrap_or(0);
    let under = pulls[top..].iter().position(|x| *x < 0.05 * peak);
    course.slack = under.map_or(0.0, |at| (LOOK * (top + at + 3)) as f64);
    let rest = rest(specimen, body);
    (course.welded, course.borne) = (rest.elastic, rest.pull / peak);
    course
}

/// The state of rest at that opening. Velocities fade; they are not set to nought when they are
/// greatest, since that feeds the grid's fastest modes.
fn rest(specimen: &Specimen, body: &mut dyn Body) -> Now {
    body.hold(specimen);
    for _ in 0..REST {
        body.advance();
        body.damp();
    }
    now(specimen, body)
}

fn specimen(seed: u64) -> Specimen {
    // The plane lies half way between nodes: CPIC would give those of the plane to one side.
    Specimen { middle: Vec3::new(0.0, 0.5, 0.0), ..Specimen::straight(HALF, seed) }
}

fn mean(courses: &[Course], value: impl Fn(&Course) -> f64) -> f64 {
    courses.iter().map(value).sum::<f64>() / courses.len() as f64
}

type Make = fn(Specimen) -> Box<dyn Body>;

/// The courses of a method over seeds; prints a row of the table.
fn method(name: &str, seeds: &[u64], make: Make) -> Vec<Course> {
    let courses: Vec<Course> =
        seeds.par_iter().map(|&seed| run(&specimen(seed), &mut *make(specimen(seed)))).collect();
    let cells: Vec<String> = (0..8)
        .map(|k| {
            let all: Vec<f64> = courses.iter().map(|c| c.values()[k]).collect();
            let middle = all.iter().sum::<f64>() / all.len() as f64;
            let spread = all.iter().fold(0.0_f64, |m, x| m.max((x - middle).abs()));
            format!("{middle:.3} ± {spread:.3}")
        })
        .collect();
    println!("| {name} | {} |", cells.join(" | "));
    courses
}

/// F17: with one field the sides of a crack hold on to each other; CPIC's faces keep what pull
/// they had. Layers of broken points, energy spent, and what is still held when all has come to
/// rest (thesis Fig. 3.17 and 3.19).
#[test]
fn two_fields_let_go_of_what_others_hold() {
    println!("| method | layers | cut | slack | spent | elastic | kinetic | welded | borne |");
    let seeds = [3, 4, 5];
    let one = method("one field", &seeds, |s| Box::new(s.domain(WAY, VelocityFields::Single)));
    let ours = method("ours", &seeds, |s| Box::new(s.domain(WAY, VelocityFields::Split)));
    let cpic = method("CPIC", &seeds, |s| Box::new(Twin::new(s, WAY, Some(Coupling::Compatible))));
    let leaky = |s| -> Box<dyn Body> { Box::new(Twin::new(s, WAY, Some(Coupling::Leaky))) };
    method("CPIC, thesis (A.4)", &seeds[..1], leaky);
    let whole = |s| -> Box<dyn Body> { Box::new(Twin::new(s, WAY, Some(Coupling::Whole))) };
    method("one field, twin", &seeds[..1], whole);
    let layers = [&ours, &one].map(|m| mean(m, |c| c.layers));
    assert!(layers[0] < 0.92 * layers[1], "{layers:?}");
    let welded = [&ours, &one, &cpic].map(|m| mean(m, |c| c.welded));
    assert!(welded[0] < 0.5 * welded[1] && welded[0] < 0.25 * welded[2], "{welded:?} J");
    let borne = [&ours, &cpic].map(|m| mean(m, |c| c.borne));
    assert!(borne[0].abs() < 0.01 && borne[1] > 0.03, "{borne:?}");
}

/// With nothing open the twin is the solver with one field: so what differs above is the parting.
#[test]
fn the_twin_agrees_where_nothing_is_open() {
    let specimen = specimen(3);
    let mut twin = Twin::new(specimen, WAY, None);
    let mut domain = specimen.unbroken(WAY);
    for step in 1..=120 {
        domain.advance();
        Twin::advance(&mut twin);
        if step % 30 == 0 {
            let (a, b) = (now(&specimen, &domain), now(&specimen, &twin));
            println!("{step}: {a:?} {b:?}");
            assert!((b.elastic / a.elastic - 1.0).abs() < 0.02);
            assert!((b.pull / a.pull - 1.0).abs() < 0.02);
        }
    }
}

/// What each bears across a plane that opens whole while it is pulled, over what it bore.
#[test]
fn a_plane_that_opens_bears_nothing() {
    let specimen = specimen(3);
    let pulled = |body: &mut dyn Body| {
        (0..60).for_each(|_| _ = body.advance());
        now(&specimen, body).pull
    };
    let mut domain = specimen.unbroken(WAY);
    let before = pulled(&mut domain);
    domain.sever(|a, b| specimen.local(a).y > 0.0 && specimen.local(b).y < 0.0);
    let ours = rest(&specimen, &mut domain).pull / before;
    let mut twin = Twin::new(specimen, WAY, None);
    let before = pulled(&mut twin);
    twin.open();
    let cpic = rest(&specimen, &mut twin).pull / before;
    println!("borne: ours {ours:.4}, CPIC {cpic:.4}");
    assert!(ours.abs() < 0.01, "{ours}");
    assert!(cpic > 0.1, "{cpic}");
}
