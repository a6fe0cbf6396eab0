//! What rests writes nothing: a recording grows only while something moves.

use super::super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use super::{halves, settlement};
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Quat, Vec3};
use cullet_model::{Fragmentation, Grain};
use cullet_pool::Settlement;
use cullet_proto::JobId;
use cullet_record::{PoseRow, Recording};
use cullet_scene::load;
use nalgebra::Unit;
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A pool that cuts a cube of 10 cm into halves, and a millimetre of the second into grains, of
/// which the first flies long.
struct Crumbler(RefCell<VecDeque<JobId>>);

impl JobPool for Crumbler {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let id = JobId::of(&job.encode().expect("a job"));
        self.0.borrow_mut().push_back(id);
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let id = self.0.borrow_mut().pop_front()?;
        Some((id, settlement(crumbled().into())))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

fn crumbled() -> Fragmentation {
    let mut broken = halves(0.0);
    let second = &mut broken.fragments[1];
    let mesh = cuboid(Vec3::new(0.049, 0.1, 0.1), Detail::default()).expect("a box");
    second.solid.mesh = mesh.translated(Vec3::new(0.0245, 0.0, 0.0));
    second.hulls = vec![second.solid.mesh.vertices.clone()];
    // As the scene turns the cube.
    let axis = Unit::new_normalize(Vec3::new(1.0, 1.0, 0.2));
    let turn = Quat::from_axis_angle(&axis, 50_f64.to_radians());
    let grain = |k: u32| {
        let position = Vec3::new(0.0495, 0.02 * f64::from(k) - 0.04, 0.0);
        let velocity = turn.inverse() * Vec3::z() * if k == 0 { 30.0 } else { 1.0 };
        Grain { position, velocity, volume: 2e-6, size: 0.0156 }
    };
    broken.debris = (0..5).map(grain).collect();
    broken
}

#[test]
fn what_rests_has_no_rows() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/corpus/drop.toml");
    // No piece falls off it.
    let floor = "body.floor.shape={ kind = \"box\", size = [200.0, 200.0, 0.2] }";
    let sets = ["body.right.breakable=false", "world.max_generation=1", "world.duration=8", floor];
    let scene = load(Path::new(scene), &sets.map(str::to_owned)).expect("a scene");
    let (stop, out) = (AtomicBool::new(false), tempfile::tempdir().expect("a folder"));
    let options = RunOptions::new(out.path(), &stop);
    let outcome = run(&scene, &Crumbler(RefCell::default()), &options, &mut |_| {});
    let outcome = outcome.expect("a run");
    let recording = Recording::open(&outcome.recording).expect("a recording");
    assert_eq!(recording.summary().digest, outcome.summary.digest);

    let bits = |row: &PoseRow| {
        let (p, q) = (row.pose.translation.vector, row.pose.rotation);
        let (v, w) = (row.velocity, row.spin);
        [p.x, p.y, p.z, q.i, q.j, q.k, q.w, v.x, v.y, v.z, w.x, w.y, w.z].map(f64::to_bits)
    };
    let mut last = BTreeMap::new();
    for poses in &recording.poses {
        for row in PoseRow::of(poses) {
            let before = last.insert(row.id, bits(&row));
            assert_ne!(before, Some(bits(&row)), "body {} at {} s", row.id, poses.time);
        }
    }
    let moved = recording.poses.last().expect("poses").time;
    assert!(moved < 7.0, "all bodies sleep long before the end; the last row is of {moved} s");

    let mut last: BTreeMap<u64, (f64, Vec<u64>)> = BTreeMap::new();
    for rows in &recording.debris {
        let columns = rows.positions.as_chunks::<3>().0.iter().zip(rows.velocities.chunks(3));
        for (id, (at, v)) in rows.ids.iter().zip(columns) {
            let row: Vec<u64> = at.iter().chain(v).map(|value| value.to_bits()).collect();
            let before = last.insert(*id, (rows.time, row.clone()));
            assert!(before.is_none_or(|before| before.1 != row), "grain {id} at {} s", rows.time);
        }
    }
    assert_eq!(last.len(), 5);
    let long = last[&0].0;
    let most = last.values().skip(1).map(|row| row.0).fold(0.0, f64::max);
    assert!(most + 0.5 < long, "the others lie from {most} s on, the oldest flies until {long} s");
}
