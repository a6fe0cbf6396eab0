//! What joints carry, from the balance of a step.
//!
//! The engine's own joint impulses jitter. But what a body's joints gave it in sum is known: the
//! change of its momentum and of its angular momentum over the step, without gravity, fields and
//! contacts. How the joints of a group share that is [`ElasticFrame`]'s.
//!
//! Normal impulses of contacts are the engine's. Friction is known exactly where the partner has no
//! other contact and no joint: there it is what its own balance leaves. Elsewhere the engine's
//! friction of the last substep stands for the whole step, and a weak element to the ground takes
//! the error.

use crate::elastic_frame::{ElasticFrame, FrameElement, FrameNode};
use crate::exchange::{Exchange, Rest, rest, sums};
use crate::groups::{JointedGroup, find_groups};
use crate::joint::{JointLimit, JointLoad};
use crate::jointed::{CarryingFace, JointLink, Jointed, points};
use crate::motion::Motion;
use crate::over_step::{acceleration, mean_motion, stepped};
use crate::rigid::Contact;
use crate::state::WorldState;
use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use std::collections::BTreeMap;

/// What all joints did over a step.
#[derive(Default)]
pub(crate) struct StepLoads {
    /// The mean load of each.
    pub(crate) loads: BTreeMap<u32, JointLoad>,
    /// What each body that moves got from its joints in sum.
    pub(crate) held: BTreeMap<u32, Exchange>,
    /// Groups whose loads were worked out, and those that did not converge.
    pub(crate) solves: [u64; 2],
}

/// Stiffness of friction that is not known over that of the joints \[1\]: it takes what no joint
/// can.
const FRICTION: f64 = 1e-3;
/// Shear modulus over Young's of a joint \[1\].
const SHEAR: f64 = 0.4;
/// A rope that is shorter than its length by more than this share does not pull \[1\].
const SLACK: f64 = 1e-3;
/// A rope that would push is left out, and the rest shared anew, so many times.
const MOST_SLACK: usize = 8;

/// The loads of all joints over the step just taken.
pub(crate) fn find_loads(world: &mut WorldState, contacts: &[Contact]) -> StepLoads {
    let mut found = StepLoads::default();
    if world.joints.all.is_empty() {
        return found;
    }
    let mut groups = world.joints.groups.take().unwrap_or_else(|| {
        let moves = |id: u32| world.bodies.get(&id).is_some_and(|body| !body.immovable());
        find_groups(&world.joints.all, moves)
    });
    let contacts = StepContacts::new(world, contacts);
    for group in &mut groups {
        if group.bodies.iter().all(|&id| world.rigid.sleeping(id)) {
            continue;
        }
        load(world, group, &contacts, &mut found);
    }
    world.joints.groups = Some(groups);
    found
}

/// The contacts of a step.
struct StepContacts<'a> {
    all: &'a [Contact],
    /// Numbers of those of each body, rising.
    of: BTreeMap<u32, Vec<usize>>,
    /// Friction on the partner of each body that touches nothing else and has no joints, by
    /// contact.
    friction: BTreeMap<usize, (u32, Exchange)>,
}

impl<'a> StepContacts<'a> {
    fn new(world: &WorldState, all: &'a [Contact]) -> Self {
        let mut of: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (k, contact) in all.iter().enumerate() {
            for id in [contact.a, contact.b] {
                of.entry(id).or_default().push(k);
            }
        }
        Self { all, of, friction: known_friction(world, all) }
    }

    /// Those of a body, with their numbers.
    fn of(&self, id: u32) -> impl Iterator<Item = (usize, &'a Contact)> {
        let own = self.of.get(&id).map_or(&[][..], Vec::as_slice);
        own.iter().map(|&k| (k, &self.all[k]))
    }

    /// Those of some bodies, each once, with their numbers.
    fn of_all(&self, ids: &[u32]) -> BTreeMap<usize, &'a Contact> {
        ids.iter().flat_map(|&id| self.of(id)).collect()
    }
}

/// [`StepContacts::friction`].
fn known_friction(world: &WorldState, contacts: &[Contact]) -> BTreeMap<usize, (u32, Exchange)> {
    let sums = sums(contacts);
    let dt = world.settings.step;
    let mut known = BTreeMap::new();
    for (k, contact) in contacts.iter().enumerate() {
        for (id, partner) in [(contact.a, contact.b), (contact.b, contact.a)] {
            let Some(normals) = sums.get(&id).filter(|normals| normals.single()) else { continue };
            if !world.joints.of.contains_key(&partner) || world.joints.of.contains_key(&id) {
                continue;
            }
            let (Some((_, stepped)), Some(motion)) =
                (stepped(world, id), world.rigid.before(partner))
            else {
                continue;
            };
            let rest: Rest = rest(&stepped, &acceleration(world, id), dt, normals, None);
            let linear = -rest.linear();
            let torque = (contact.moment / contact.impulse - motion.centre()).cross(&linear);
            known.insert(k, (partner, Exchange { linear, torque }));
        }
    }
    known
}

impl GroupFrame {
    fn push(&mut self, element: FrameElement, joint: Option<u32>, rope: Option<Vec3>) {
        self.elements.push(element);
        self.joints.push(joint);
        self.ropes.push(rope);
    }
}

/// A group's frame in its own axes: those of its first body.
#[derive(Default)]
struct GroupFrame {
    elements: Vec<FrameElement>,
    /// The joint of each; none of friction.
    joints: Vec<Option<u32>>,
    /// Of ropes, the unit direction from the first to the second end.
    ropes: Vec<Option<Vec3>>,
    needed: Vec<Exchange>,
}

/// The body half way through the step.
fn middle(world: &WorldState, id: u32) -> Option<Pose> {
    let (one, two) = (world.rigid.before(id)?.pose, world.rigid.motion(id)?.pose);
    Some(Pose::from_parts(
        ((one.translation.vector + two.translation.vector) / 2.0).into(),
        one.rotation.nlerp(&two.rotation, 0.5),
    ))
}

fn load(
    world: &WorldState,
    group: &mut JointedGroup,
    contacts: &StepContacts<'_>,
    found: &mut StepLoads,
) {
    let poses: BTreeMap<u32, Pose> =
        group.bodies.iter().filter_map(|&id| Some((id, middle(world, id)?))).collect();
    let Some(axes) = group.bodies.first().and_then(|id| poses.get(id)).map(|pose| pose.rotation)
    else {
        return;
    };
    let back = axes.inverse();
    let places = group.places();
    let Some(nodes) = nodes(world, group, &poses, &back) else { return };
    let mut frame = GroupFrame::default();
    for &id in &group.bodies {
        let need = needed(world, id, contacts);
        let turned = |v: Vec3| back * v;
        frame.needed.push(Exchange { linear: turned(need.linear), torque: turned(need.torque) });
    }
    for &id in &group.joints {
        if let Some((element, rope)) = joint_element(world, id, &places, &poses, &back) {
            frame.push(element, Some(id), rope);
        }
    }
    add_friction((&places, &poses, &back), contacts, &mut frame);
    let given = share_out(group, &nodes, &mut frame, found);
    let dt = world.settings.step;
    for ((id, element), given) in frame.joints.iter().zip(&frame.elements).zip(given) {
        let Some(joint) = id.and_then(|id| world.joints.all.get(&id)) else { continue };
        let (linear, torque) = (axes * given.linear, axes * given.torque);
        for ((end, arm), sign) in element.ends.iter().zip(&element.arms).zip([-1.0, 1.0]) {
            if let Some(place) = *end {
                let own = Exchange { linear, torque: torque + (axes * arm).cross(&linear) };
                let held = found.held.entry(group.bodies[place]).or_insert_with(Exchange::zero);
                held.add(&own.scaled(sign));
            }
        }
        let turn = pose_of(world, &poses, Some(joint.a)).rotation;
        let load = load_of(joint, &turn, linear / dt, torque / dt);
        found.loads.extend(id.map(|id| (id, load)));
    }
}

/// Solves, and leaves out ropes that would push.
fn share_out(
    group: &mut JointedGroup,
    nodes: &[FrameNode],
    frame: &mut GroupFrame,
    found: &mut StepLoads,
) -> Vec<Exchange> {
    let mut given = Vec::new();
    for _ in 0..MOST_SLACK {
        let elastic = ElasticFrame::new(nodes, &frame.elements, &group.first);
        let solution = elastic.solve(&frame.needed, &mut group.factor);
        given = solution.given;
        found.solves[0] += 1;
        found.solves[1] += u64::from(!solution.converged);
        let mut pushes = false;
        for ((rope, element), given) in frame.ropes.iter().zip(&mut frame.elements).zip(&mut given)
        {
            if rope.is_some_and(|along| along.dot(&given.linear) > 0.0) {
                (element.force, *given, pushes) = (Mat3::zeros(), Exchange::zero(), true);
            }
        }
        if !pushes {
            break;
        }
    }
    given
}

fn nodes(
    world: &WorldState,
    group: &JointedGroup,
    poses: &BTreeMap<u32, Pose>,
    back: &Quat,
) -> Option<Vec<FrameNode>> {
    let turned = |inertia: Mat3| {
        let turn = back.to_rotation_matrix();
        turn.matrix() * inertia * turn.matrix().transpose()
    };
    let node = |id: &u32| {
        let (body, pose) = (world.bodies.get(id)?, poses.get(id)?);
        Some(FrameNode { mass: body.mass, inertia: turned(body.world_inertia(pose)) })
    };
    group.bodies.iter().map(node).collect()
}

/// What the joints of a body gave it in sum, and friction that is not known.
fn needed(world: &WorldState, id: u32, contacts: &StepContacts<'_>) -> Exchange {
    let Some((body, stepped)) = stepped(world, id) else { return Exchange::zero() };
    let (before, after, dt) = (&stepped.before, &stepped.after, world.settings.step);
    let damping = world.rigid.damping(id) * dt;
    let mean = (before.velocity + after.velocity) / 2.0;
    let gained = after.velocity - before.velocity + mean * damping;
    let mut need = Exchange {
        linear: (gained - acceleration(world, id) * dt) * body.mass,
        torque: stepped.inertia_after * after.spin * (1.0 + damping / 2.0)
            - stepped.inertia * before.spin * (1.0 - damping / 2.0),
    };
    for (k, contact) in contacts.of(id) {
        let (sign, torque) = match id {
            id if id == contact.a => (-1.0, contact.torque_a),
            id if id == contact.b => (1.0, contact.torque_b),
            _ => continue,
        };
        need.add(&Exchange { linear: contact.on_b * -sign, torque: -torque });
        let rub = match contacts.friction.get(&k) {
            Some((body, known)) if *body == id => *known,
            _ => {
                let linear = contact.rub * sign;
                let arm = contact.moment / contact.impulse - before.centre();
                Exchange { linear, torque: arm.cross(&linear) }
            }
        };
        need.add(&rub.scaled(-1.0));
    }
    need
}

fn pose_of(world: &WorldState, poses: &BTreeMap<u32, Pose>, id: Option<u32>) -> Pose {
    let elsewhere = |id| middle(world, id).unwrap_or_else(Pose::identity);
    id.map_or_else(Pose::identity, |id| poses.get(&id).copied().unwrap_or_else(|| elsewhere(id)))
}

/// The element of a joint, and the direction of a rope; none where nothing is held.
fn joint_element(
    world: &WorldState,
    id: u32,
    places: &BTreeMap<u32, usize>,
    poses: &BTreeMap<u32, Pose>,
    back: &Quat,
) -> Option<(FrameElement, Option<Vec3>)> {
    let joint = world.joints.all.get(&id)?;
    let [a, b] = [Some(joint.a), joint.b].map(|end| pose_of(world, poses, end));
    let [one, two] = points(joint, &a, &b);
    let turn = back * a.rotation;
    let mut rope = None;
    let (force, torque) = match joint.link {
        JointLink::Rope { length } => {
            let along = (back * (two - one)).try_normalize(0.0)?;
            if longest(world, joint) < length * (1.0 - SLACK) {
                return None;
            }
            rope = Some(along);
            (along * along.transpose() * joint.face.area, Mat3::zeros())
        }
        _ => stiffness(joint, &turn),
    };
    // A joint that has given a little still gives both the same, at one point.
    let point = (one + two) / 2.0;
    let held_at = if rope.is_some() { [one, two] } else { [point, point] };
    let end = |id: Option<u32>| id.and_then(|id| places.get(&id).copied());
    let ends = [end(Some(joint.a)), end(joint.b)];
    let arms =
        [back * (held_at[0] - a.translation.vector), back * (held_at[1] - b.translation.vector)];
    Some((FrameElement { ends, arms, force, torque }, rope))
}

/// Greatest distance of the ends of a rope, before and after the step \[m\].
fn longest(world: &WorldState, joint: &Jointed) -> f64 {
    let apart = |pose: &dyn Fn(u32) -> Option<Pose>| {
        let a = pose(joint.a)?;
        let b = joint.b.map_or_else(|| Some(Pose::identity()), pose)?;
        let [one, two] = points(joint, &a, &b);
        Some((two - one).norm())
    };
    let before = apart(&|id| world.rigid.before(id).map(|motion: &Motion| motion.pose));
    let after = apart(&|id| world.rigid.motion(id).map(|motion| motion.pose));
    before.unwrap_or(0.0).max(after.unwrap_or(0.0))
}

/// Force and torque over displacement and rotation, with Young's modulus over thickness as the
/// unit; `turn` leads from the frame of the joint's first body.
fn stiffness(joint: &Jointed, turn: &Quat) -> (Mat3, Mat3) {
    let CarryingFace { normal, area, tensor, .. } = &joint.face;
    let (force, mut torque) = match normal {
        Some(n) => {
            let across = n * n.transpose();
            let force = (across + (Mat3::identity() - across) * SHEAR) * *area;
            let cross = n.cross_matrix();
            let bending = cross * tensor * cross.transpose();
            (force, bending + across * (SHEAR * tensor.trace()))
        }
        None => (Mat3::identity() * *area, *tensor),
    };
    match joint.link {
        JointLink::Rigid => {}
        JointLink::Hinge { axis } => {
            let held = Mat3::identity() - axis * axis.transpose();
            torque = held * torque * held;
        }
        JointLink::Ball | JointLink::Rope { .. } => torque = Mat3::zeros(),
    }
    let turn = turn.to_rotation_matrix();
    let turned = |m: Mat3| turn.matrix() * m * turn.matrix().transpose();
    (turned(force), turned(torque))
}

/// Weak elements for friction that is not known.
fn add_friction(
    (places, poses, back): (&BTreeMap<u32, usize>, &BTreeMap<u32, Pose>, &Quat),
    contacts: &StepContacts<'_>,
    frame: &mut GroupFrame,
) {
    let stiffness: f64 = frame.elements.iter().map(|e| e.force.trace() / 3.0).sum();
    let weak = FRICTION * stiffness / frame.elements.len().max(1) as f64;
    let bodies: Vec<u32> = places.keys().copied().collect();
    for (k, contact) in contacts.of_all(&bodies) {
        let ends = [contact.a, contact.b].map(|id| places.get(&id).copied());
        let Some(n) = contact.on_b.try_normalize(0.0) else { continue };
        if contacts.friction.contains_key(&k) {
            continue;
        }
        let (n, point) = (back * n, contact.moment / contact.impulse);
        let arms = [contact.a, contact.b].map(|id| {
            poses.get(&id).map_or_else(Vec3::zeros, |pose| back * (point - pose.translation.vector))
        });
        let force = (Mat3::identity() - n * n.transpose()) * weak;
        frame.push(FrameElement { ends, arms, force, torque: Mat3::zeros() }, None, None);
    }
}

/// Work of driven bodies on others by the joints that they hold them with \[J\], each with its
/// body: what the other side takes up, at the mean of its velocities before and after the step.
pub(crate) fn joint_work(world: &WorldState, loads: &StepLoads) -> Vec<(u32, f64)> {
    let dt = world.settings.step;
    let mut work = Vec::new();
    for (id, load) in &loads.loads {
        let Some(joint) = world.joints.all.get(id) else { continue };
        let ends = [Some(joint.a), joint.b];
        for (side, driver) in ends.into_iter().enumerate() {
            let is_driven =
                |id: &u32| world.bodies.get(id).is_some_and(|body| body.driven.is_some());
            let (Some(driver), other) = (driver.filter(is_driven), ends[1 - side]) else {
                continue;
            };
            let Some((speed, spin)) =
                other.and_then(|id| mean_motion(world, id, joint.ends[1 - side]))
            else {
                continue;
            };
            // The load is what the second side gets.
            let sign = if side == 0 { 1.0 } else { -1.0 };
            work.push((driver, sign * (load.force.dot(&speed) + load.torque.dot(&spin)) * dt));
        }
    }
    work
}

/// A joint's load, and its share of what the joint bears; `turn` leads from the frame of its first
/// body to the world's.
fn load_of(joint: &Jointed, turn: &Quat, force: Vec3, torque: Vec3) -> JointLoad {
    let over = |value: f64, limit: Option<f64>| limit.map_or(0.0, |limit| value / limit);
    let normal = joint.face.normal.map(|n| turn * n);
    let share = match joint.limit {
        JointLimit::Whole(limits) => {
            over(force.norm(), limits.force).max(over(torque.norm(), limits.torque))
        }
        JointLimit::Pull(limits) => {
            let pressed = normal.map_or_else(Vec3::zeros, |n| n * force.dot(&n).max(0.0));
            over((force - pressed).norm(), limits.force).max(over(torque.norm(), limits.torque))
        }
        JointLimit::Stress { tensile, shear } => {
            let back = turn.inverse();
            let [tension, sliding] = stresses(&joint.face, &(back * force), &(back * torque));
            (tension / tensile).max(sliding / shear)
        }
    };
    JointLoad { force, torque, share }
}

/// Greatest tension at a corner, not below zero, and shear stress \[Pa\], in the face's frame.
///
/// Tractions −(N/A + c·r) n on the second body have the torque −(Σ c) × n, Σ = ∫ r rᵀ dA.
fn stresses(face: &CarryingFace, force: &Vec3, torque: &Vec3) -> [f64; 2] {
    let Some(n) = face.normal else { return [0.0; 2] };
    let polar = face.tensor.trace();
    let regular = face.tensor + n * n.transpose() * polar;
    let slope =
        regular.try_inverse().map_or_else(Vec3::zeros, |inverse| inverse * torque.cross(&n));
    let even = -force.dot(&n) / face.area;
    let tension = face.corners.iter().map(|r| even + slope.dot(r)).fold(0.0, f64::max);
    let farthest = face.corners.iter().map(Vec3::norm).fold(0.0, f64::max);
    let sliding = (force - n * force.dot(&n)).norm() / face.area;
    let torsion = if polar > 0.0 { torque.dot(&n).abs() * farthest / polar } else { 0.0 };
    [tension, sliding + torsion]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square face of side 0.2 m: σ = N/A + M/W with W = a³/6, τ = V/A.
    #[test]
    fn stresses_are_those_of_a_beam() {
        let (side, n) = (0.2f64, Vec3::x());
        let half = side / 2.0;
        let corner = |y: f64, z: f64| Vec3::new(0.0, y * half, z * half);
        let moment = side.powi(4) / 12.0;
        let face = CarryingFace {
            normal: Some(n),
            area: side * side,
            tensor: Mat3::from_diagonal(&Vec3::new(0.0, moment, moment)),
            corners: vec![corner(1., 1.), corner(-1., 1.), corner(-1., -1.), corner(1., -1.)],
        };
        let none = Vec3::zeros();
        let [tension, shear] = stresses(&face, &Vec3::new(-80.0, 3.0, 4.0), &none);
        assert!((tension - 2000.0).abs() < 1e-9 && (shear - 125.0).abs() < 1e-9);
        let bent = 6.0 / side.powi(3);
        for torque in [Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()] {
            let [tension, shear] = stresses(&face, &none, &torque);
            assert!((tension - bent).abs() < 1e-9 * bent && shear == 0.0, "{tension} of {bent}");
        }
        // Pressed as much as bent: nothing pulls.
        let [tension, _] = stresses(&face, &(n * bent * side * side), &Vec3::y());
        assert!(tension < 1e-9 * bent, "{tension}");
        let [_, twisted] = stresses(&face, &none, &n);
        assert!((twisted - half * 2f64.sqrt() / (2.0 * moment)).abs() < 1e-9 * twisted);
        // What hangs below a face is pulled away from the side of the face that it hangs at.
        let down = stresses(&face, &Vec3::zeros(), &Vec3::y());
        assert!(down[0] > 0.0);
    }
}
