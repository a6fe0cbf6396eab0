//! Seams: where a body slides from one convex part to the next that lies flush with it.
//!
//! Contact is foreseen. A box that slides over tiles is foreseen to meet the side of the next one,
//! for it lies a few hundredths of a millimetre deep in the top of this one, and would be stopped
//! or tripped. Such a contact is none: where one of two parts reaches past a face of the other by
//! no more than their room, that face alone holds it, and no side beside the face.
//!
//! A ball is foreseen to meet the edge of the next tile as well, aslant, and lies a little deep in
//! it before it is over it. Such an edge is left out where a face that is flush with it held the
//! ball in the last step.

use super::convert::vec3;
use cullet_geometry::Vec3;
use rapier3d_f64::parry::math::Pose;
use rapier3d_f64::parry::shape::Shape;
use rapier3d_f64::prelude::{
    ColliderHandle, ContactModificationContext, IntegrationParameters, ModifiableContacts,
    PhysicsWorld, Vector,
};
use std::collections::BTreeMap;

/// A face that faces less than this share of the way that a contact pushes is beside it \[1\].
const BESIDE: f64 = 0.7;
/// What lies on a part may be as deep in it as so many of the engine's own errors of places \[1\] …
const ERRORS: f64 = 1.5;
/// … and so many times as far as gravity moves a body in a step (balls: 1.2, at 8 m/s 3.4) \[1\].
const SAGS: f64 = 4.0;

/// How far one of two parts may reach past a face of the other and lie on it \[m\].
pub(super) fn seam_room(of: &IntegrationParameters, gravity: Vector) -> f64 {
    ERRORS * of.allowed_linear_error() + SAGS * gravity.length() * of.dt * of.dt
}

/// A face that faces at least this share of the way that a contact pushes is what it is with \[1\].
const FACING: f64 = 0.999_99;

/// Ways \[1\] in which what touched each ball in the last step pushed it.
#[derive(Default)]
pub(super) struct HeldBalls(BTreeMap<(u32, u32), Vec<Vector>>);

impl HeldBalls {
    pub(super) fn of(world: &PhysicsWorld) -> Self {
        let balls = world.colliders.iter().filter(|(_, it)| it.shape().as_ball().is_some());
        let ways = |ball: ColliderHandle| {
            let mut ways = Vec::new();
            for pair in world.narrow_phase.contact_pairs_with(ball) {
                let away = if pair.collider1 == ball { -1.0 } else { 1.0 };
                let touching = pair.solver_manifolds().iter();
                let touching = touching.filter(|it| !it.data.solver_contacts.is_empty());
                ways.extend(touching.map(|manifold| manifold.data.normal * away));
            }
            ways
        };
        Self(balls.map(|(ball, _)| (ball.into_raw_parts(), ways(ball))).collect())
    }

    /// Whether what pushes two parts along a normal is an edge of one of them beside a ball that a
    /// face flush with one at that edge held.
    pub(super) fn is_at_edge(
        &self,
        handles: [ColliderHandle; 2],
        placed: [(&dyn Shape, &Pose); 2],
        normal: Vector,
        room: f64,
    ) -> bool {
        [(0, 1, -normal), (1, 0, normal)].into_iter().any(|(ball, part, push)| {
            let Some(ways) = self.0.get(&handles[ball].into_raw_parts()) else { return false };
            let is_edge = |outward: Vector| {
                outward.dot(push) < FACING && ways.iter().any(|way| way.dot(outward) >= FACING)
            };
            hardly_past(placed[part], placed[ball], room, is_edge)
        })
    }
}

/// Leaves out a contact of a ball with an edge of a part where a face of the part that it hardly
/// reaches past is flush with what held it.
pub(super) fn leave_out_edges(
    context: &mut ContactModificationContext<'_>,
    held: &HeldBalls,
    room: f64,
) {
    let handles = [context.collider1, context.collider2];
    let parts = handles.map(|it| context.colliders.get(it));
    let [Some(one), Some(two)] = parts else { return };
    let ModifiableContacts::Rigid(contacts) = &mut context.contacts else { return };
    let placed = [one, two].map(|part| (part.shape(), part.position()));
    if held.is_at_edge(handles, placed, *contacts.normal, room) {
        contacts.solver_contacts.clear();
    }
}

/// Leaves out contacts that are foreseen at a side; `step` \[s\], `room`: of seams
/// \[m\].
pub(super) fn leave_out_sides(context: &mut ContactModificationContext<'_>, step: f64, room: f64) {
    let parts = [context.collider1, context.collider2].map(|it| context.colliders.get(it));
    let [Some(one), Some(two)] = parts else { return };
    let bodies = [context.rigid_body1, context.rigid_body2];
    let bodies = bodies.map(|handle| handle.and_then(|handle| context.bodies.get(handle)));
    let ModifiableContacts::Rigid(contacts) = &mut context.contacts else { return };
    let normal = *contacts.normal;
    let velocity = |k: usize, at: Vector| {
        bodies[k].map_or_else(Vec3::zeros, |body| vec3(body.velocity_at_point(at)))
    };
    // Near enough to act within the step, and not there yet.
    let mut all = contacts.solver_contacts.iter();
    let closes = all.clone().any(|contact| {
        let speed = velocity(0, contact.anchor1) - velocity(1, contact.anchor2);
        speed.dot(&vec3(normal)) * step > contact.dist
    });
    if closes && all.all(|contact| contact.dist > 0.0) {
        let placed = [one, two].map(|part| (part.shape(), part.position()));
        if is_at_side(placed, normal, room) {
            contacts.solver_contacts.clear();
        }
    }
}

/// Whether what pushes two parts along a normal is a side of one of them, past a face of which the
/// other hardly reaches.
pub(super) fn is_at_side([one, two]: [(&dyn Shape, &Pose); 2], normal: Vector, room: f64) -> bool {
    let beside = |outward: Vector| outward.dot(normal).abs() <= BESIDE;
    hardly_past(one, two, room, beside) || hardly_past(two, one, room, beside)
}

/// Whether a shape reaches past one of those faces of a convex part by no more than their room.
fn hardly_past(
    (part, pose): (&dyn Shape, &Pose),
    (shape, at): (&dyn Shape, &Pose),
    room: f64,
    of_those: impl Fn(Vector) -> bool,
) -> bool {
    let (Some(hull), Some(map)) = (part.as_convex_polyhedron(), shape.as_support_map()) else {
        return false;
    };
    hull.faces().iter().any(|face| {
        let outward = pose.rotation * face.normal;
        if !of_those(outward) {
            return false;
        }
        let first = hull.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
        let height = outward.dot(*pose * hull.points()[first as usize]);
        let lowest = outward.dot(map.support_point(at, -outward));
        (height - lowest).abs() <= room
    })
}
