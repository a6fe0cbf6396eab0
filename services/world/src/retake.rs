//! The engine's step, taken again without the joints that break in it.
//!
//! The engine hands a blow through a whole glued wall within one step, so that all joints of it
//! would be over their limits at once. But the first to break spares the others. So the worst are
//! taken out, and the step is taken again from where it began.

use crate::body::Body;
use crate::error::WorldError;
use crate::id::BodyId;
use crate::joint::{JointBreak, JointId};
use crate::joint_store::MOST_RETAKES;
use crate::jointed::points;
use crate::joints::take_out;
use crate::loads::{StepLoads, find_loads, joint_work};
use crate::rigid::Contact;
use crate::state::WorldState;
use cullet_geometry::Pose;

/// Joints whose share is within this of the greatest break with it \[1\].
const ALIKE: f64 = 0.05;

/// A step of the engine, in its last version.
pub(crate) struct Advance {
    pub(crate) contacts: Vec<Contact>,
    pub(crate) loads: StepLoads,
    /// Work of driven bodies on others by joints \[J\], those that broke included.
    pub(crate) work: Vec<(u32, f64)>,
}

/// Lets the engine take a step; joints that break in it are gone, as if they had not been there.
pub(crate) fn advance(world: &mut WorldState) -> Result<Advance, WorldError> {
    world.joints.broken.clear();
    world.rigid.set_fields(&world.fields, &world.last_fields);
    let saved = may_break(world).then(|| world.rigid.save());
    let mut gone: Vec<u32> = Vec::new();
    let mut round = 0;
    let most = MOST_RETAKES - world.joints.fewer_retakes.min(MOST_RETAKES);
    loop {
        world.rigid.step().map_err(|_| WorldError::Engine { step: world.steps })?;
        check_finite(world)?;
        let contacts = world.rigid.contacts();
        let loads = find_loads(world, &contacts);
        world.joints.counts.solves += loads.solves[0];
        world.joints.counts.not_converged += loads.solves[1];
        let over = overloaded(&loads);
        let again = saved.as_ref().filter(|_| round < most && !over.is_empty());
        let least = 1 << (round / 2);
        let breaking = if again.is_some() { worst(&over, least) } else { &over };
        let broken: Vec<JointBreak> =
            breaking.iter().filter_map(|&(id, share)| broken(world, &loads, id, share)).collect();
        world.joints.broken.extend(broken);
        let Some(saved) = again else {
            let work = joint_work(world, &loads);
            breaking.iter().for_each(|&(id, _)| drop(take_out(world, id)));
            keep(world, &loads);
            world.joints.counts.steps_retaken += u64::from(round > 0);
            return Ok(Advance { contacts, loads, work });
        };
        gone.extend(breaking.iter().map(|&(id, _)| id));
        world.rigid.restore(saved);
        for &id in &gone {
            // Those of earlier rounds are out of the books already.
            if take_out(world, id).is_none() {
                world.rigid.unjoin(id);
            }
        }
        world.joints.counts.retakes += 1;
        round += 1;
    }
}

/// May a joint with a limit break in this step? Whatever is awake may wake what sleeps within the
/// step, and so may fields and driven bodies.
fn may_break(world: &WorldState) -> bool {
    let acts = |(&id, body): (&u32, &Body)| match &body.driven {
        Some(path) => path.end() > world.time() - world.settings.step,
        None => !body.immovable() && !world.rigid.sleeping(id),
    };
    world.joints.all.values().any(|joint| joint.limit.breakable())
        && (world.fields != world.last_fields || world.bodies.iter().any(acts))
}

/// Joints over their limits, the worst first, then in order.
fn overloaded(loads: &StepLoads) -> Vec<(u32, f64)> {
    let shares = loads.loads.iter().map(|(&id, load)| (id, load.share));
    let mut over: Vec<(u32, f64)> = shares.filter(|(_, share)| *share > 1.0).collect();
    over.sort_by(|(a, x), (b, y)| y.total_cmp(x).then(a.cmp(b)));
    over
}

/// The first `least` of those over their limits, and all that are like the first.
fn worst(over: &[(u32, f64)], least: usize) -> &[(u32, f64)] {
    let greatest = over.first().map_or(0.0, |(_, share)| *share);
    let alike = over.partition_point(|(_, share)| *share >= greatest * (1.0 - ALIKE));
    &over[..alike.max(least).min(over.len())]
}

fn broken(world: &WorldState, loads: &StepLoads, id: u32, share: f64) -> Option<JointBreak> {
    let (joint, load) = (world.joints.all.get(&id)?, loads.loads.get(&id)?);
    let a = world.rigid.before(joint.a)?.pose;
    let b =
        joint.b.map_or_else(|| Some(Pose::identity()), |b| Some(world.rigid.before(b)?.pose))?;
    Some(JointBreak {
        joint: JointId(id),
        a: BodyId(joint.a),
        b: joint.b.map(BodyId),
        step: world.steps,
        point: points(joint, &a, &b)[0],
        force: load.force.norm(),
        torque: load.torque.norm(),
        share,
    })
}

/// Notes what each joint carries.
fn keep(world: &mut WorldState, loads: &StepLoads) {
    for (id, load) in &loads.loads {
        if let Some(joint) = world.joints.all.get_mut(id) {
            joint.load = *load;
        }
    }
}

fn check_finite(world: &WorldState) -> Result<(), WorldError> {
    let lost = world.rigid.quarantined().or_else(|| {
        let finite = |id: u32| world.rigid.motion(id).is_none_or(|m| m.finite());
        world.bodies.keys().copied().find(|&id| !finite(id))
    });
    let name = |id: u32| world.bodies.get(&id).map_or_else(String::new, |body| body.name.clone());
    match lost {
        Some(id) => Err(WorldError::NotFinite { name: name(id), step: world.steps }),
        None => Ok(()),
    }
}
