//! Joints and glue of the scene: made, followed and recorded. What they bear the world decides.

use super::{Event, Level, RunError, SceneRun, number};
use cullet_geometry::Vec3;
use cullet_proto::recording::{BodyJoint, JointType, Vector3};
use cullet_scene::directions::{GlueStrength, SceneGlue, SceneJoint};
use cullet_scene::format::JointForm;
use cullet_world::{
    BodyId, GlueBodies, GlueLimit, GlueSpec, JointId, JointKind, JointLimit, JointLimits,
    JointSpec, JointView,
};

/// Most bodies that a line names.
const NAMED: usize = 3;

impl SceneRun<'_> {
    /// Makes all joints of the scene. `bodies`: those of the scene in the world, in its order.
    pub(super) fn join_bodies(&mut self, bodies: &[BodyId]) -> Result<(), RunError> {
        let scene = self.scene;
        for (index, joint) in scene.directions.joints.iter().enumerate() {
            let Some(spec) = joint_spec(joint, bodies) else { continue };
            let what = format!("joint[{index}]");
            self.world.join(&spec).map_err(|source| RunError::Joint { what, source })?;
        }
        for (index, glue) in scene.directions.glue.iter().enumerate() {
            let what = format!("glue[{index}]");
            let spec = glue_spec(glue, bodies);
            let made = self.world.glue(&spec);
            let made = made.map_err(|source| RunError::Joint { what: what.clone(), source })?;
            let (joints, area) = (made.joints.len(), made.area);
            self.say(format!("{what}: {joints} joints over {area:.4} m\u{b2}"));
            if !made.alone.is_empty() {
                let names = self.names_of(&made.alone);
                let gap = glue.gap;
                let line =
                    format!("warning: {what} holds nothing of {names}: no face within {gap} m");
                self.recorder.log(Level::Warning, line.clone())?;
                self.say(line);
            }
        }
        self.record_joints(false)
    }

    fn names_of(&self, bodies: &[BodyId]) -> String {
        let name = |id: &BodyId| self.world.body(*id).map(|view| format!("`{}`", view.name));
        let named: Vec<String> = bodies.iter().take(NAMED).filter_map(name).collect();
        let more = match bodies.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        named.join(", ") + &more
    }

    /// Records the joints that broke in the step just taken.
    pub(super) fn record_breaks(&mut self) -> Result<(), RunError> {
        for broken in self.world.broken_joints().to_vec() {
            self.joints.remove(&broken.joint);
            self.event(&Event::JointBroken {
                joint: broken.joint.0.into(),
                body: number(broken.a),
                other: broken.b.map(number),
                point: broken.point,
                force: broken.force,
                torque: broken.torque,
                share: broken.share,
            })?;
        }
        Ok(())
    }

    /// Records what became of joints of bodies that broke or were removed.
    pub(super) fn follow_joints(&mut self) -> Result<(), RunError> {
        if !std::mem::take(&mut self.joints_changed) || self.joints.is_empty() {
            return Ok(());
        }
        let there: Vec<JointId> = self.world.joints().map(|view| view.id).collect();
        let lost = |(id, _): &(&JointId, _)| there.binary_search(id).is_err();
        let gone: Vec<(JointId, (BodyId, Option<BodyId>))> =
            self.joints.iter().filter(lost).map(|(id, ends)| (*id, *ends)).collect();
        for (joint, (body, other)) in gone {
            self.joints.remove(&joint);
            let reason = "a body of it broke, or was removed".to_owned();
            let (body, other) = (number(body), other.map(number));
            self.event(&Event::JointGone { joint: joint.0.into(), body, other, reason })?;
        }
        self.record_joints(true)
    }

    /// Records joints that are new.
    fn record_joints(&mut self, inherited: bool) -> Result<(), RunError> {
        let new = |view: &JointView| !self.joints.contains_key(&view.id);
        let made: Vec<JointView> = self.world.joints().filter(new).collect();
        for view in made {
            self.joints.insert(view.id, (view.a, view.b));
            let (step, time) = (self.world.step_count(), self.world.time());
            let told = BodyJoint { step, time, inherited, ..recorded(&view) };
            self.recorder.joint(&told)?;
        }
        Ok(())
    }

    /// Records what driven bodies did, at the end of the run.
    pub(super) fn record_driven(&mut self) -> Result<(), RunError> {
        let driven = self.world.bodies().filter(|view| view.driven).map(|view| view.id);
        let works: Vec<(BodyId, f64)> =
            driven.map(|id| (id, self.world.driven_work_of(id).unwrap_or_default())).collect();
        for (id, work) in works {
            self.event(&Event::Driven { body: number(id), work })?;
        }
        let counts = self.world.joint_counts();
        if counts.not_converged > 0 {
            let line = format!(
                "warning: the loads of joints did not converge in {} of {} groups: they are as \
                 good as they got",
                counts.not_converged, counts.solves
            );
            self.recorder.log(Level::Warning, line.clone())?;
            self.say(line);
        }
        Ok(())
    }
}

/// A joint as the world takes it; nothing of one that joins nothing.
fn joint_spec(joint: &SceneJoint, bodies: &[BodyId]) -> Option<JointSpec> {
    let body = |end: usize| joint.bodies[end].and_then(|index| bodies.get(index)).copied();
    // The world is the second of the two.
    let (first, second) = if joint.bodies[0].is_some() { (0, 1) } else { (1, 0) };
    let kind = match joint.kind {
        JointForm::Rigid => JointKind::Rigid,
        JointForm::Hinge => JointKind::Hinge { axis: joint.axis },
        JointForm::Ball => JointKind::Ball,
        JointForm::Rope => JointKind::Rope { length: joint.length },
    };
    let rope = joint.kind == JointForm::Rope;
    Some(JointSpec {
        a: body(first)?,
        b: body(second),
        kind,
        anchor: joint.anchors[first],
        anchor_b: rope.then_some(joint.anchors[second]),
        limits: JointLimits { force: joint.force, torque: joint.torque },
        area: None,
        collide: joint.collide,
    })
}

fn glue_spec(glue: &SceneGlue, bodies: &[BodyId]) -> GlueSpec {
    let group = glue.bodies.iter().filter_map(|index| bodies.get(*index)).copied();
    let limit = match glue.strength {
        GlueStrength::Pair { force, torque } => GlueLimit::EachPair { force: Some(force), torque },
        GlueStrength::Area { tensile, shear } => GlueLimit::Stress { tensile, shear },
    };
    GlueSpec { bodies: GlueBodies::Group(group.collect()), limit, gap: glue.gap }
}

fn recorded(view: &JointView) -> BodyJoint {
    let vector = |v: Vec3| Some(Vector3 { x: v.x, y: v.y, z: v.z });
    let (kind, axis, length) = match view.kind {
        JointKind::Rigid => (JointType::Rigid, None, 0.0),
        JointKind::Hinge { axis } => (JointType::Hinge, vector(axis), 0.0),
        JointKind::Ball => (JointType::Ball, None, 0.0),
        JointKind::Rope { length } => (JointType::Rope, None, length),
    };
    let base = BodyJoint {
        id: view.id.0.into(),
        kind: kind as i32,
        body: number(view.a),
        other: view.b.map(number),
        point: vector(view.point),
        other_point: vector(view.point_b),
        axis,
        length,
        ..BodyJoint::default()
    };
    match view.limit {
        JointLimit::Whole(JointLimits { force, torque }) => BodyJoint { force, torque, ..base },
        JointLimit::Pull(JointLimits { force, torque }) => {
            BodyJoint { force, torque, glue: true, area: view.area, ..base }
        }
        JointLimit::Stress { tensile, shear } => {
            let (tensile, shear) = (Some(tensile), Some(shear));
            BodyJoint { tensile, shear, glue: true, area: view.area, ..base }
        }
    }
}
