//! One step of the world: the engine moves the bodies, contacts become hits.

use crate::body::Body;
use crate::cluster::Part;
use crate::episode::Episode;
use crate::error::WorldError;
use crate::exchange::{Received, received, rest, sums};
use crate::id::BodyId;
use crate::impact::{EpisodeOutcome, Hit, Party, effective_mass, hits};
use crate::loads::StepLoads;
use crate::over_step::{acceleration, stepped};
use crate::places::check_places;
use crate::retake::{Advance, advance};
use crate::rigid::Contact;
use crate::state::WorldState;

/// [`crate::World::step`].
pub(crate) fn step(world: &mut WorldState) -> Result<Vec<Hit>, WorldError> {
    let start = world.time();
    world.steps += 1;
    let Advance { contacts, loads, work } = advance(world)?;
    check_places(world)?;
    let WorldState { settings, rigid, debris, .. } = &mut *world;
    debris.advance(&settings.gravity, settings.step, rigid);
    let received = received_over_step(world, &contacts, &loads);
    follow(world, &contacts, &received, start);
    book(world, &contacts, &received, work);
    book_sleep(world);
    see_who_settles(world);
    let settings = &world.settings;
    let over = world.episodes.take_over(world.time(), settings.resting_speed, settings.episode);
    let judged = over.iter().flat_map(|(pair, episode)| judge(world, *pair, episode));
    let mut hits: Vec<Hit> = judged.collect();
    hits.sort_by_key(|hit| (hit.body, hit.episode));
    Ok(hits)
}

/// Opens episodes and takes in one step of those that are open.
fn follow(world: &mut WorldState, contacts: &[Contact], received: &[[Received; 2]], start: f64) {
    world.episodes.begin_step();
    let longest = (world.settings.episode / world.settings.step).ceil() as u64 + 2;
    world.resting.forget(world.steps.saturating_sub(longest));
    let dt = world.settings.step;
    for (contact, received) in contacts.iter().zip(received) {
        let pair = (contact.a, contact.b);
        let (Some(a), Some(b)) = (world.bodies.get(&pair.0), world.bodies.get(&pair.1)) else {
            continue;
        };
        let before = [world.rigid.before(pair.0).copied(), world.rigid.before(pair.1).copied()];
        let [Some(before_a), Some(before_b)] = before else {
            continue;
        };
        let Some(n) = contact.on_b.try_normalize(0.0) else {
            continue;
        };
        let fall = |id: u32, body: &Body| {
            if body.immovable() { 0.0 } else { acceleration(world, id).dot(&n) }
        };
        let (fall_a, fall_b) = (fall(pair.0, a), fall(pair.1, b));
        let closing_gain = (fall_a - fall_b).max(0.0) * dt;
        let speed = contact.closing_speed();
        let fresh = !world.episodes.open.contains_key(&pair);
        world.settling.touch(pair.0, &before_a);
        world.settling.touch(pair.1, &before_b);
        if fresh {
            let young = a.birth.max(b.birth) + world.settings.birth_grace > start
                && !(a.blow.strikers.contains(&pair.1) || b.blow.strikers.contains(&pair.0));
            let pause = world.settings.episode;
            let least = world.settings.resting_speed;
            if speed <= world.settling.least(pair, [a.fixed, b.fixed], least) {
                world.resting.add(contact, world.steps, *received);
                continue;
            }
            if young || !world.episodes.ready(pair, start, pause, speed) {
                continue;
            }
            // Gravity works until they touch: for the time that the gap takes in this step, and
            // in the last one for as long as they moved.
            let late = |id: u32, fall: f64| fall * dt * (1.0 - world.rigid.moved(id));
            let early = (contact.gap() / (speed * dt)).min(1.0);
            let touch = speed + early * closing_gain - late(pair.0, fall_a) + late(pair.1, fall_b);
            world.episodes.open(contact, start, [before_a, before_b], touch);
            world.settling.end(pair.0);
            world.settling.end(pair.1);
        }
        let point = contact.moment / contact.impulse;
        let mass = effective_mass((a, &before_a), (b, &before_b), &point, &n);
        let weight = mass * closing_gain * if fresh { 0.5 } else { 1.0 };
        if let Some(episode) = world.episodes.open.get_mut(&pair) {
            episode.add(contact, weight, received);
        }
    }
}

fn see_who_settles(world: &mut WorldState) {
    let (now, resting) = (world.time(), world.settings.resting_speed);
    let (rigid, bodies) = (&world.rigid, &world.bodies);
    let motion = |id: u32| Some((rigid.motion(id)?, bodies.get(&id)?.reach));
    world.settling.look(now, resting, motion);
}

/// What both bodies of each pair received from their contact over the last step.
fn received_over_step(
    world: &WorldState,
    contacts: &[Contact],
    loads: &StepLoads,
) -> Vec<[Received; 2]> {
    let moving = |(id, normals)| {
        let (_, stepped) = stepped(world, id)?;
        let (given, dt) = (acceleration(world, id), world.settings.step);
        Some((id, rest(&stepped, &given, dt, &normals, loads.held.get(&id))))
    };
    let driven = world.bodies.iter().filter(|(_, body)| body.driven.is_some());
    let driven = driven.filter_map(|(&id, _)| Some((id, *world.rigid.before(id)?)));
    let rests = sums(contacts).into_iter().filter_map(moving).collect();
    received(contacts, rests, &driven.collect())
}

/// Books what driven bodies and fields did over the step; `work`: of driven bodies by joints.
fn book(
    world: &mut WorldState,
    contacts: &[Contact],
    received: &[[Received; 2]],
    mut work: Vec<(u32, f64)>,
) {
    for (contact, received) in contacts.iter().zip(received) {
        // What a driver loses is what it does.
        work.push((contact.a, received[0].taken));
        work.push((contact.b, received[1].taken));
    }
    for (id, work) in work {
        if world.bodies.get(&id).is_some_and(|body| body.driven.is_some()) {
            world.flows.driven_work += work;
            *world.driven_work.entry(id).or_insert(0.0) += work;
        }
    }
    let dt = world.settings.step;
    for (&id, field) in &world.fields {
        let Some((body, stepped)) = stepped(world, id) else { continue };
        let impulse = field * (body.mass * dt);
        let mean = (stepped.before.velocity + stepped.after.velocity) / 2.0;
        world.flows.field_work += impulse.dot(&mean);
        world.flows.field_impulse += impulse;
    }
    world.last_fields = std::mem::take(&mut world.fields);
}

/// Books what bodies had that fell asleep over the step: the engine stops them.
fn book_sleep(world: &mut WorldState) {
    let (rigid, flows) = (&world.rigid, &mut world.flows);
    for (&id, body) in world.bodies.iter().filter(|(_, body)| !body.immovable()) {
        let Some(before) = rigid.before(id).filter(|_| rigid.sleeping(id)) else { continue };
        // What slept before the step had nothing.
        let part = Part::new(body, before);
        flows.slept_momentum += part.momentum();
        flows.slept_energy += part.kinetic();
    }
}

/// The hits of a finished episode: none, or one a body that may break and whose threshold it
/// reached.
fn judge(world: &WorldState, (a, b): (u32, u32), episode: &Episode) -> Vec<Hit> {
    let (Some(one), Some(two)) = (world.bodies.get(&b), world.bodies.get(&a)) else {
        return Vec::new();
    };
    let impulse = episode.net_impulse();
    let over = |body: &Body| {
        body.breakable
            && impulse > 0.0
            && impulse >= body.threshold.unwrap_or(world.settings.impulse_threshold)
    };
    let Some(normal) = episode.normal().filter(|_| over(one) || over(two)) else {
        return Vec::new();
    };
    let outcome = EpisodeOutcome {
        episode: episode.number,
        time: episode.opened,
        point: episode.point(),
        normal,
        impulse,
        closing_speed: episode.closing_speed,
        step: world.steps,
        dissipated: episode.dissipated.max(0.0),
    };
    let party = |id: u32, body, side: usize| Party {
        id: BodyId(id),
        body,
        motion: &episode.first[side],
        exchanged: episode.exchanged[side],
    };
    let [first, second] = hits(&outcome, &party(b, one, 1), &party(a, two, 0));
    let each = [(over(one), first), (over(two), second)];
    each.into_iter().filter(|(over, _)| *over).map(|(_, hit)| hit).collect()
}
