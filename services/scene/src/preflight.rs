//! What is certain of a scene before it runs: that nothing in it can break, or that something only
//! falls. Everything here is a bound: where it is silent, nothing is promised.

use super::directions::SceneDirections;
use super::format::World;
use super::scene::SceneBody;
use cullet_document::check::tell;
use cullet_geometry::Vec3;
use std::collections::VecDeque;

/// Names told of several bodies; the others are counted.
const NAMED: usize = 3;

/// Pieces that the way of a body is looked at in.
const PIECES: u32 = 128;

/// Most pairs of bodies that are looked at: in a scene with more of them nothing is said.
const MOST_PAIRS: usize = 4_000_000;

/// What is said, a line each.
pub(super) fn warnings(
    world: &World,
    bodies: &[SceneBody],
    sheets: bool,
    directions: &SceneDirections,
) -> Vec<String> {
    // A sheet may catch what falls, and is torn whatever bodies do; joints hold bodies, and break.
    if bodies.is_empty() || sheets || directions.joins() {
        return Vec::new();
    }
    if !directions.fields.is_empty() || bodies.iter().any(|body| body.drive.is_some()) {
        // Who pushes and pulls gives what impulse it likes, and bodies go other ways.
        return surely_unbreakable(world, bodies).into_iter().collect();
    }
    let ways: Vec<Way> = bodies.iter().map(|body| Way::of(body, world)).collect();
    let lonely = meets_nothing(world, bodies, &ways);
    let falls = falling(world, bodies, &ways);
    [cannot_break(world, bodies, &lonely), falls].into_iter().flatten().collect()
}

/// What a body's own weight or spin does to it, where that alone reaches its strength: σ_f below
/// ρgL, or ρv² of its rim (F02).
pub(super) fn own_load(body: &SceneBody, gravity: &[f64; 3]) -> Option<String> {
    if body.fixed || !body.breakable {
        return None;
    }
    let gravity = Vec3::from(*gravity);
    let turned = |p: &Vec3| body.pose.rotation * p;
    let depths = body.solid.mesh.vertices.iter().map(|p| gravity.dot(&turned(p)));
    let (low, high) =
        depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
    let rims = body.solid.mesh.vertices.iter().map(|p| body.spin.cross(&turned(p)).norm_squared());
    let material = &body.material;
    let (weight, rim) =
        (material.density * (high - low), material.density * rims.fold(0.0, f64::max));
    let strength = body.weakest * material.strength;
    let (load, name) = if rim > weight { (rim, "its spin") } else { (weight, "its own weight") };
    (load > strength).then(|| {
        format!("{name} stresses it by {load:.3e} Pa, its strength is {strength:.3e} Pa (F02)")
    })
}

/// Why nothing in the scene can break however it moves, if so.
fn surely_unbreakable(world: &World, bodies: &[SceneBody]) -> Option<String> {
    let why = if bodies.iter().all(|body| body.fixed) {
        "all its bodies are fixed".to_owned()
    } else if !bodies.iter().any(|body| body.breakable) {
        unbreakable(bodies)
    } else if world.max_generation == 0 {
        "world.max_generation is 0, the generation of its bodies".to_owned()
    } else {
        return None;
    };
    Some(format!("nothing in this scene can break: {why}"))
}

/// Why nothing in the scene can break, if so.
fn cannot_break(world: &World, bodies: &[SceneBody], lonely: &[bool]) -> Option<String> {
    if let Some(line) = surely_unbreakable(world, bodies) {
        return Some(line);
    }
    let why = if bodies.iter().zip(lonely).all(|(body, lonely)| *lonely || !body.breakable) {
        let (can, end) = (names(bodies.iter().filter(|body| body.breakable)), tell(world.duration));
        format!("{can} can, and meets nothing in the {end} s of the run")
    } else {
        threshold(world, bodies)?
    };
    Some(format!("nothing in this scene can break: {why}"))
}

/// What the bodies of a scene are none of which can break.
fn unbreakable(bodies: &[SceneBody]) -> String {
    let moving = || bodies.iter().filter(|body| !body.fixed && body.drive.is_none());
    let tough = || moving().filter(|body| !body.material.breakable);
    let kept = names(moving().filter(|body| body.material.breakable));
    let mut materials: Vec<&str> = tough().map(|body| body.material.name.as_str()).collect();
    materials.sort_unstable();
    materials.dedup();
    let tough = (!materials.is_empty()).then(|| {
        format!("{} is made of what does not break: {}", names(tough()), materials.join(", "))
    });
    let kept = (!kept.is_empty()).then(|| format!("{kept} has `breakable = false`"));
    let fixed = bodies.iter().any(|body| body.fixed).then(|| "what is fixed does not".to_owned());
    let driven = bodies.iter().any(|body| body.drive.is_some());
    let driven = driven.then(|| "what is driven does not".to_owned());
    [tough, kept, fixed, driven].into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// That no hit can be as hard as the least threshold. No contact gives more than twice the momentum
/// that all energy of the scene makes of all its mass, and what the weight of all gives in the run.
fn threshold(world: &World, bodies: &[SceneBody]) -> Option<String> {
    let (gravity, time) = (Vec3::from(world.gravity).norm(), world.duration);
    let (mut mass, mut energy) = (0.0, 0.0);
    for body in bodies.iter().filter(|body| !body.fixed) {
        let (m, v) = (body.volume * body.material.density, body.velocity.norm());
        let spin = body.inertia.norm() * body.material.density * body.spin.norm_squared();
        let drop = v * time + 0.5 * gravity * time * time;
        mass += m;
        energy += 0.5 * m * v * v + 0.5 * spin + m * gravity * drop;
    }
    let most = 2.0 * (2.0 * energy * mass).sqrt() + mass * gravity * time;
    let least = bodies.iter().filter(|body| body.breakable);
    let least = least.map(|body| body.impulse_threshold.unwrap_or(world.impulse_threshold));
    let least = least.fold(f64::INFINITY, f64::min);
    (most < least).then(|| {
        format!("a hit breaks from {} N·s on, and none here can give {most:.3}", tell(least))
    })
}

/// Which bodies have nothing fixed in their way, nor anything that has: under gravity they fall.
fn falling(world: &World, bodies: &[SceneBody], ways: &[Way]) -> Option<String> {
    let gravity = Vec3::from(world.gravity).norm();
    if gravity <= 0.0 || bodies.iter().all(|body| body.fixed) {
        return None;
    }
    let held = held(world, bodies, ways)?;
    let free: Vec<&SceneBody> =
        bodies.iter().zip(&held).filter(|(_, held)| !**held).map(|(body, _)| body).collect();
    let end = tell(world.duration);
    match free.len() {
        0 => None,
        _ if bodies.iter().all(|body| !body.fixed) => Some(format!(
            "there is no floor: no body is fixed, and under gravity all of them fall for all the \
             {end} s of the run"
        )),
        _ => Some(format!(
            "there is no floor under {}: nothing fixed is in the way, and it falls for all the \
             {end} s of the run",
            names(free.into_iter())
        )),
    }
}

/// Which bodies are fixed, meet something fixed, or meet one that does.
fn held(world: &World, bodies: &[SceneBody], ways: &[Way]) -> Option<Vec<bool>> {
    let fixed: Vec<&Way> =
        ways.iter().zip(bodies).filter(|(_, body)| body.fixed).map(|(way, _)| way).collect();
    let count = fixed.len().checked_mul(bodies.len())?;
    if count > MOST_PAIRS {
        return None;
    }
    let reaches = |way: &Way| fixed.iter().any(|fixed| way.reaches(fixed, world));
    let mut held: Vec<bool> =
        bodies.iter().zip(ways).map(|(body, way)| body.fixed || reaches(way)).collect();
    let mut free: Vec<usize> = (0..bodies.len()).filter(|&i| !held[i]).collect();
    if free.len().checked_mul(bodies.len())? > MOST_PAIRS {
        return None;
    }
    let mut next: VecDeque<usize> =
        (0..bodies.len()).filter(|&i| held[i] && !bodies[i].fixed).collect();
    while let Some(i) = next.pop_front() {
        free.retain(|&j| {
            let met = ways[i].meets(&ways[j], world.duration);
            if met {
                held[j] = true;
                next.push_back(j);
            }
            !met
        });
    }
    Some(held)
}

/// Which bodies meet no other one. Of a scene with too many bodies none is said to.
fn meets_nothing(world: &World, bodies: &[SceneBody], ways: &[Way]) -> Vec<bool> {
    if bodies.len().saturating_mul(bodies.len()) > MOST_PAIRS {
        return vec![false; bodies.len()];
    }
    let meet = |i: usize, j: usize| match (bodies[i].fixed, bodies[j].fixed) {
        (true, true) => false,
        (false, true) => ways[i].reaches(&ways[j], world),
        (true, false) => ways[j].reaches(&ways[i], world),
        (false, false) => ways[i].meets(&ways[j], world.duration),
    };
    let all = 0..bodies.len();
    all.clone().map(|i| !all.clone().any(|j| i != j && meet(i, j))).collect()
}

/// Where a body is, and where it goes as long as it meets nothing.
struct Way {
    centre: Vec3,
    velocity: Vec3,
    /// Of the ball about its centre that holds it \[m\].
    radius: f64,
    /// Corners of the box that holds it as it stands \[m\].
    low: Vec3,
    high: Vec3,
    /// Corners of the box that holds its centre's way through the run \[m\].
    reach: (Vec3, Vec3),
}

impl Way {
    fn of(body: &SceneBody, world: &World) -> Self {
        let centre = body.pose.translation.vector;
        let corners = || body.hulls.iter().flatten();
        let radius = corners().map(Vec3::norm).fold(0.0, f64::max);
        let placed = corners().map(|corner| body.pose.rotation * corner + centre);
        let ends = placed.fold((centre, centre), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let mut way = Self {
            centre,
            velocity: body.velocity,
            radius,
            low: ends.0,
            high: ends.1,
            reach: (centre, centre),
        };
        if !body.fixed {
            way.reach = way.between(world, 0.0, world.duration);
        }
        way
    }

    fn at(&self, world: &World, time: f64) -> Vec3 {
        self.centre + self.velocity * time + Vec3::from(world.gravity) * (0.5 * time * time)
    }

    /// Corners of a box that holds its centre between two times.
    fn between(&self, world: &World, from: f64, to: f64) -> (Vec3, Vec3) {
        let (a, b) = (self.at(world, from), self.at(world, to));
        // A parabola leaves its chord by no more than g t² / 8.
        let sag = Vec3::from(world.gravity).abs() * (0.125 * (to - from) * (to - from));
        (a.inf(&b) - sag, a.sup(&b) + sag)
    }

    /// Whether it may come to a body that stands where it is.
    fn reaches(&self, fixed: &Self, world: &World) -> bool {
        let (low, high) = (fixed.low.add_scalar(-self.radius), fixed.high.add_scalar(self.radius));
        let overlap =
            |(from, to): (Vec3, Vec3)| (0..3).all(|k| from[k] <= high[k] && to[k] >= low[k]);
        let piece = world.duration / f64::from(PIECES);
        let time = |k: u32| piece * f64::from(k);
        overlap(self.reach)
            && (0..PIECES).any(|k| overlap(self.between(world, time(k), time(k + 1))))
    }

    /// Whether it may come to another body that moves: both fall alike, so that seen from one the
    /// other goes straight on.
    fn meets(&self, other: &Self, duration: f64) -> bool {
        let (apart, speed) = (other.centre - self.centre, other.velocity - self.velocity);
        let square = speed.norm_squared();
        let time =
            if square > 0.0 { (-apart.dot(&speed) / square).clamp(0.0, duration) } else { 0.0 };
        (apart + speed * time).norm() <= self.radius + other.radius
    }
}

/// Names of bodies; after a few of them, how many more there are.
fn names<'a>(bodies: impl Iterator<Item = &'a SceneBody>) -> String {
    let all: Vec<String> = bodies.map(|body| format!("`{}`", body.name)).collect();
    match all.len() {
        0 => String::new(),
        1 => all[0].clone(),
        n if n <= NAMED => format!("each of {}", all.join(", ")),
        n => format!("each of {} and {} more", all[..NAMED].join(", "), n - NAMED),
    }
}
