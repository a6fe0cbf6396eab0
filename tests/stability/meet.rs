//! Bodies that are so fast that a step takes them past each other (F42).

use crate::bodies::{
    GLASS, STEEL, any, any3, body, cells, cuboid, floor, put, settings, sphere, steps, until_hit,
    weightless,
};
use cullet_geometry::{Pose, Quat, Solid, Vec3};
use cullet_world::{BodyId, BodySpec, Hit, World, WorldSettings};
use std::collections::BTreeMap;

/// F42: a bullet that flies twenty times a wall's thickness in a step hits it, and does not come
/// out behind.
#[test]
fn f42_a_fast_ball_does_not_pass_through_a_thin_wall() {
    for speed in [50.0, 200.0] {
        let mut world = World::new(weightless()).expect("settings");
        assert!(speed * world.settings().step > 10.0 * 0.01, "it is fast");
        let wall = cuboid(Vec3::new(0.01, 0.4, 0.4));
        let wall = put(&mut world, body("wall", wall, GLASS, Vec3::zeros()));
        let ball = body("ball", sphere(0.005, 6), STEEL, Vec3::new(-0.7, 0.0, 0.0));
        let ball = put(&mut world, BodySpec { velocity: Vec3::new(speed, 0.0, 0.0), ..ball });
        let hits = until_hit(&mut world, 20);
        let x = world.body(ball).expect("there").pose.translation.vector.x;
        assert!(hits.iter().any(|hit| hit.body == wall), "{speed} m/s: {hits:?}");
        assert!(x < 0.0, "{speed} m/s: the ball is at {x}");
        let full = world.body(ball).expect("there").mass * speed;
        let got = hits[0].impact.impulse;
        assert!(got > 0.99 * full && got < 1.5 * full, "{speed} m/s: {got} of {full} N·s");
    }
}

type Shape = fn() -> (Solid, Vec<Vec<Vec3>>);

/// What flies, where it is and how fast \[m, m/s\].
type Flying = (Shape, Vec3, Vec3);

fn flight(step: f64, flying: &[Flying]) -> (World, Vec<BodyId>) {
    let mut world = World::new(WorldSettings { step, ..weightless() }).expect("settings");
    let ids = flying.iter().map(|&(shape, at, velocity)| {
        put(&mut world, BodySpec { velocity, ..body("ball", shape(), STEEL, at) })
    });
    let ids = ids.collect();
    (world, ids)
}

fn ball() -> (Solid, Vec<Vec<Vec3>>) {
    sphere(0.05, 8)
}

fn plate() -> (Solid, Vec<Vec<Vec3>>) {
    cuboid(Vec3::new(0.02, 0.2, 0.2))
}

/// What is wrong with how two meet that fly along x with these speeds, the second so far aside.
fn clash(step: f64, shape: Shape, aside: f64, [u, v]: [f64; 2]) -> Option<String> {
    let at = [Vec3::new(-0.53, 0.0, 0.0), Vec3::new(0.47, aside, 0.01)];
    let (mut world, ids) =
        flight(step, &[(shape, at[0], u * Vec3::x()), (shape, at[1], v * Vec3::x())]);
    let before = world.totals();
    let hits = steps(&mut world, (1.0 / ((u - v) * step)) as u32 + 12);
    let after = world.totals();
    let error = (after.momentum - before.momentum).norm();
    let [left, right] = [0, 1].map(|k| world.body(ids[k]).expect("there").pose);
    let apart = right.translation.x - left.translation.x;
    let full = 0.25 * before.mass * (u - v);
    let got = hits.first().map_or(0.0, |hit| hit.impact.impulse) / full;
    let head_on = aside <= 0.005;
    let sound = hits.len() == 2
        && error < 1e-12 * before.mass * (u - v)
        && after.kinetic_energy <= before.kinetic_energy * (1.0 + 1e-9)
        && (!head_on || (apart > 0.0 && got > 0.97 && got < 1.6));
    let told = format!(
        "{u} and {v} m/s, {aside} m aside, a step of {step} s: {} hits, {got} of the impulse, \
         {apart} m apart, {error} N·s lost, energy {} times",
        hits.len(),
        after.kinetic_energy / before.kinetic_energy
    );
    (!sound).then_some(told)
}

/// F42: two that are both fast do not pass through each other, whatever the step; they keep their
/// momentum and make no energy; and where they miss, nothing happens.
#[test]
fn f42_fast_bodies_do_not_pass_through_each_other() {
    let mut faults = Vec::new();
    let cases = [1e-3, 1.0 / 240.0, 1.0 / 60.0].into_iter().flat_map(|step| {
        let speeds = [(20.0, -10.0), (20.0, -20.0), (40.0, -40.0), (80.0, -80.0), (90.0, 30.0)];
        speeds.into_iter().map(move |speeds| (step, speeds))
    });
    for (step, (u, v)) in cases {
        let shapes: [(Shape, f64); 6] =
            [(ball, 0.0), (ball, 0.005), (ball, 0.07), (ball, 0.095), (plate, 0.0), (plate, 0.15)];
        for (shape, aside) in shapes {
            // Slow ones may graze each other within a step, and be past it.
            if aside < 0.09 || u * step > 0.025 {
                faults.extend(clash(step, shape, aside, [u, v]));
            }
        }
        let at = [Vec3::new(-0.53, 0.0, 0.0), Vec3::new(0.47, 0.105, 0.0)];
        let (mut world, ids) =
            flight(step, &[(ball, at[0], u * Vec3::x()), (ball, at[1], v * Vec3::x())]);
        let n = (1.0 / ((u - v) * step)) as u32 + 12;
        assert!(steps(&mut world, n).is_empty(), "{u} and {v} m/s, {step} s: they miss");
        for (id, (at, speed)) in ids.iter().zip(at.into_iter().zip([u, v])) {
            let x = world.body(*id).expect("there").pose.translation.x;
            let free = at.x + speed * step * f64::from(n);
            assert!((x - free).abs() < 1e-9, "{u} and {v} m/s, {step} s: at {x}, not {free} m");
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Nearest that the middles of two bodies come to each other on straight ways \[m\].
fn nearest([a, b]: [[Vec3; 2]; 2]) -> f64 {
    let (from, to) = (b[0] - a[0], b[1] - a[1]);
    let way = to - from;
    let share = (-from.dot(&way) / way.norm_squared().max(1e-300)).clamp(0.0, 1.0);
    (from + share * way).norm()
}

/// Balls one behind the other, a little aside of a line: with any speeds; the first of them fast;
/// from both sides; all towards a wall.
fn row(case: u64) -> Vec<Flying> {
    let count = 3 + case % 3;
    let mut x = -1.0;
    let balls = (0..count).map(|k| {
        let draw = 0.5 + 0.5 * any(case, k);
        let share = k as f64 / (count - 1) as f64;
        let speed = match (case / 3) % 4 {
            0 => 160.0 * (2.0 * draw - 1.0),
            1 if k == 0 => 80.0 + 80.0 * draw,
            1 => 0.0,
            2 => 80.0 * (1.0 - 2.0 * share) * (0.5 + draw),
            _ => 160.0 * (1.0 - share) * draw + 20.0,
        };
        x += 0.351 + 0.25 * any(case, 10 + k);
        let aside = 0.01 * any3(case, 20 + k);
        (ball as Shape, Vec3::new(x, aside.y, aside.z), speed * Vec3::x())
    });
    balls.collect()
}

/// What goes wrong with the balls of a row: two whose middles come nearer than two fifths of their
/// size, or one that is behind the wall.
fn overlaps(case: u64, step: f64) -> Vec<String> {
    let flying = row(case);
    let (mut world, ids) = flight(step, &flying);
    let last = flying[flying.len() - 1].1.x + 0.2;
    let walled = (case / 3) % 4 == 3;
    if walled {
        let wall = body("wall", cuboid(Vec3::new(0.02, 8.0, 8.0)), STEEL, Vec3::x() * last);
        put(&mut world, BodySpec { fixed: true, ..wall });
    }
    let start = world.totals();
    let place = |world: &World, id| world.body(id).expect("there").pose.translation.vector;
    let mut at: Vec<Vec3> = ids.iter().map(|&id| place(&world, id)).collect();
    let (mut faults, mut hits) = (Vec::new(), 0);
    for k in 0..20 {
        hits += steps(&mut world, 1).len();
        let now: Vec<Vec3> = ids.iter().map(|&id| place(&world, id)).collect();
        for i in 0..ids.len() {
            let near = (0..i).map(|j| nearest([[at[i], now[i]], [at[j], now[j]]]));
            let least = near.fold(f64::INFINITY, f64::min);
            if least < 0.04 || (walled && now[i].x > last) {
                faults.push(format!("row {case}, {step} s, step {k}: {i} {least} m, {}", now[i].x));
            }
        }
        at = now;
    }
    let totals = world.totals();
    let error = (totals.momentum - start.momentum).norm();
    assert!(walled || error < 1e-12 * totals.mass * 200.0, "row {case}, {step} s: {error} N·s");
    if hits == 0 || totals.kinetic_energy > start.kinetic_energy * (1.0 + 1e-9) {
        let gain = totals.kinetic_energy / start.kinetic_energy;
        faults.push(format!("row {case}, {step} s: {hits} hits, {gain} times the energy"));
    }
    faults
}

/// F42: in rows of balls none passes through another: not through one that was stopped where it met
/// a third, nor through one that the step itself made fast, that spins, that the solver has not
/// yet stopped, or that something fixed has; and their momentum is kept.
#[test]
fn f42_rows_of_fast_balls_do_not_pass_through_each_other() {
    let cases = (0..72).flat_map(|case| [240.0, 120.0, 60.0].map(|rate| (case, 1.0 / rate)));
    let faults: Vec<String> = cases.flat_map(|(case, step)| overlaps(case, step)).collect();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// F42: what flies apart, or together, is not held: a block of cubes that touch, each as fast as it
/// is far from the middle, or all as fast.
#[test]
fn f42_what_does_not_close_flies_freely() {
    for (apart, along) in [(300.0, 0.0), (0.0, 150.0), (300.0, 150.0)] {
        let cubes = (0..27).map(|k| {
            let at = 0.02 * Vec3::new((k % 3) as f64, (k / 3 % 3) as f64, (k / 9) as f64);
            let small = || cuboid(Vec3::new(0.02, 0.02, 0.02));
            let at = at - Vec3::new(0.02, 0.02, 0.02);
            (small as Shape, at, apart * at + along * Vec3::x())
        });
        let cubes: Vec<Flying> = cubes.collect();
        let (mut world, ids) = flight(1.0 / 60.0, &cubes);
        assert!(steps(&mut world, 6).is_empty(), "nobody hits");
        for (id, (_, at, velocity)) in ids.iter().zip(&cubes) {
            let view = world.body(*id).expect("there");
            let error = (view.pose.translation.vector - at - velocity * 0.1).norm();
            assert!(error < 1e-9, "{apart} 1/s, {along} m/s: {error} m");
        }
    }
}

/// F42: those that have met go on with what they had together: a crowd's middle moves freely.
#[test]
fn f42_the_middle_of_a_crowd_flies_freely() {
    for (case, rate) in [(1, 60.0), (2, 240.0), (3, 1000.0)] {
        let balls = (0..12u64).map(|k| {
            let place = Vec3::new((k % 3) as f64, (k / 3 % 2) as f64, (k / 6) as f64);
            (ball as Shape, 0.11 * place, 100.0 * Vec3::x() + 20.0 * any3(case, 3 * k))
        });
        let balls: Vec<Flying> = balls.collect();
        let (mut world, ids) = flight(1.0 / rate, &balls);
        let middle = |world: &World| {
            let at = |&id: &BodyId| world.body(id).expect("there").pose.translation.vector;
            ids.iter().map(at).sum::<Vec3>() / ids.len() as f64
        };
        let before = middle(&world);
        let speed = balls.iter().map(|ball| ball.2).sum::<Vec3>() / ids.len() as f64;
        let hits = steps(&mut world, 12).len();
        let error = (middle(&world) - before - speed * (12.0 / rate)).norm();
        assert!(hits > 6, "{hits} hits");
        assert!(error < 1e-9, "{error} m at 1/{rate} s");
    }
}

/// F42: who touches one that is taken along, and is left by it, stays.
#[test]
fn f42_who_is_left_behind_stays() {
    let behind = Vec3::new(-0.05025, 0.08703, 0.0);
    let flying: [Flying; 3] = [
        (ball, Vec3::new(-0.5, -0.03, 0.0), 60.0 * Vec3::x()),
        (ball, Vec3::zeros(), Vec3::zeros()),
        (ball, behind, Vec3::zeros()),
    ];
    let (mut world, ids) = flight(1.0 / 240.0, &flying);
    assert!(!steps(&mut world, 4).is_empty(), "one is hit");
    let at = |k: usize| world.body(ids[k]).expect("there").pose.translation.vector;
    assert!(at(1).x > 0.05, "it is taken along: {}", at(1));
    assert!((at(2) - behind).norm() < 1e-12, "{}", at(2));
}

/// Body-steps whose place did not follow the velocity.
#[derive(Default)]
struct Halts {
    /// Body-steps faster than 1 m/s, before and after.
    fast: u32,
    /// Those of them that moved less than a fifth of what the velocities ask for.
    halts: u32,
    /// How many steps on end each body halts now.
    now: BTreeMap<BodyId, u32>,
    /// The most that any did.
    longest: u32,
}

/// Places and velocities of all that moves.
fn motions(world: &World) -> BTreeMap<BodyId, (Vec3, Vec3)> {
    let free = world.bodies().filter(|body| !body.fixed);
    free.map(|body| (body.id, (body.pose.translation.vector, body.velocity))).collect()
}

impl Halts {
    /// One more step. The velocity that counts is the least of those before and after the step and
    /// of their mean, so that a bounce within a step is none of these.
    fn add(&mut self, before: &BTreeMap<BodyId, (Vec3, Vec3)>, world: &World) {
        let step = world.settings().step;
        for (id, (now, after)) in motions(world) {
            let Some((from, velocity)) = before.get(&id) else {
                continue;
            };
            let mean = (velocity + after) / 2.0;
            let speed = mean.norm().min(velocity.norm()).min(after.norm());
            let halts = speed > 1.0 && (now - from).norm() < 0.2 * speed * step;
            self.fast += u32::from(speed > 1.0);
            self.halts += u32::from(halts);
            let run = self.now.entry(id).or_default();
            *run = if halts { *run + 1 } else { 0 };
            self.longest = self.longest.max(*run);
        }
    }
}

/// A hundred blocks in a bond, on a floor, and a ball of steel that comes at them with 20 m/s.
fn facade(step: f64) -> (World, BodyId) {
    let settings = WorldSettings { step, impulse_threshold: 20.0, ..settings() };
    let mut world = World::new(settings).expect("settings");
    put(&mut world, floor());
    let size = Vec3::new(0.4, 0.15, 0.2);
    for k in 0..100 {
        let (row, column) = (k / 10, f64::from(k % 10) + 0.5 * f64::from(k / 10 % 2));
        let at = Vec3::new(0.401 * (column - 5.0), 0.0, 0.1 + 0.2005 * f64::from(row));
        put(&mut world, body(&format!("block {k}"), cuboid(size), GLASS, at));
    }
    let ball = body("ball", sphere(0.25, 6), STEEL, Vec3::new(0.1, -0.5, 0.7));
    let ball = BodySpec { velocity: 20.0 * Vec3::y(), breakable: false, ..ball };
    let ball = put(&mut world, ball);
    (world, ball)
}

/// Share of the impulse of the hits that break a body that its pieces get \[1\].
const GIVEN: f64 = 0.5;

/// Has what is struck for the first time fall to pieces of this many a side, while `world` runs for
/// that long, and counts what does not follow its velocity.
fn shatter(mut world: World, time: f64, size: Vec3, n: usize) -> (Halts, World) {
    let mut halts = Halts::default();
    while world.time() < time {
        let before = motions(&world);
        let hits = world.step().expect("the step is sound");
        halts.add(&before, &world);
        let mut struck: Vec<BodyId> = hits.iter().map(|hit| hit.body).collect();
        struck.dedup();
        for id in struck {
            let first = world.body(id).is_some_and(|view| view.generation == 0 && !view.fixed);
            let of: Vec<Hit> = hits.iter().filter(|hit| hit.body == id).cloned().collect();
            if first {
                // What a hit cannot pay for stays whole.
                let mass = world.body(id).map_or(1.0, |view| view.mass);
                let given: Vec3 = of.iter().map(|h| h.impact.normal * h.impact.impulse).sum();
                let mut pieces = cells(size, n, 0.5);
                pieces.iter_mut().for_each(|piece| piece.velocity = given * (GIVEN / mass));
                world.replace(id, &of, pieces, 1.0).ok();
            }
        }
    }
    (halts, world)
}

/// F42: where a ball goes through a facade, no body hangs in the air while its velocity runs on,
/// whatever the step, and the ball comes out behind.
#[test]
fn f42_places_follow_velocities_where_a_facade_falls() {
    for (rate, time) in [(120.0, 0.6), (240.0, 0.6), (960.0, 0.3)] {
        let (world, ball) = facade(1.0 / rate);
        let (halts, world) = shatter(world, time, Vec3::new(0.4, 0.15, 0.2), 2);
        let Halts { fast, halts, longest, .. } = halts;
        let y = world.body(ball).expect("there").pose.translation.y;
        // A hundredth is what hits come to: each takes a step in which the place is that of the
        // first touch.
        let few = longest < 5 && 100 * halts <= fast;
        assert!(few, "1/{rate} s: {halts} of {fast} body-steps, {longest} on end");
        assert!(y > 1.0, "1/{rate} s: the ball is at {y} m");
    }
}

/// Cubes above each other, any way up, that fly at a floor.
fn thrown(case: u64, step: f64, count: u64) -> World {
    let mut world = World::new(WorldSettings { step, ..settings() }).expect("settings");
    put(&mut world, floor());
    for k in 0..count {
        let at = Vec3::new(0.02 * any(case, 9 * k), 0.02 * any(case, 9 * k + 1), 0.12);
        let spec = body("cube", cuboid(Vec3::new(0.1, 0.1, 0.1)), GLASS, at);
        let turn = Quat::from_scaled_axis(3.0 * any3(case, 9 * k + 2));
        let pose = Pose::from_parts((at + 0.19 * k as f64 * Vec3::z()).into(), turn);
        let velocity = 3.0 * any3(case, 9 * k + 5) - 16.0 * Vec3::z();
        put(&mut world, BodySpec { pose, velocity, ..spec });
    }
    world
}

/// F42: where the pieces of cubes land on each other and on a floor, none hangs in the air while
/// its velocity runs on, not even one that others push away from the floor as fast as it falls, so
/// that the engine never has the two in contact.
#[test]
fn f42_places_follow_velocities_where_pieces_land_in_heaps() {
    let mut faults = Vec::new();
    for (case, count) in (0..12).flat_map(|case| [(case, 2), (case, 3)]) {
        for rate in [120.0, 240.0] {
            let world = thrown(case, 1.0 / rate, count);
            let (halts, _) = shatter(world, 0.15, Vec3::repeat(0.1), 2);
            assert!(halts.fast > 100, "they fly");
            if halts.longest > 2 {
                let Halts { halts, fast, longest, .. } = halts;
                let told = format!("{halts} of {fast} body-steps, {longest} on end");
                faults.push(format!("case {case}, {count} cubes, 1/{rate} s: {told}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
