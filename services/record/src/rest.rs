//! Where fragments lie in the whole object: rest poses.

use super::{PoseRow, Recording};
use cullet_geometry::{Pose, Vec3};
use cullet_proto::recording::Body;
use std::collections::BTreeMap;

/// Where the frame of a body lies in that of the body of the scene that it comes from, before
/// anything moved. Axes are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestPlace {
    /// The body of the scene.
    pub root: u64,
    /// The origin of the body in the frame of `root` at its birth \[m\].
    pub origin: Vec3,
}

/// How far masses may be from the mass of the body that broke, to count as all of it \[1\].
const WHOLE: f64 = 1e-6;

impl Recording {
    /// Where each body was first recorded.
    fn first_poses(&self) -> BTreeMap<u64, Pose> {
        let mut first = BTreeMap::new();
        for row in self.poses.iter().flat_map(PoseRow::of) {
            first.entry(row.id).or_insert(row.pose);
        }
        first
    }

    /// Where each body was when it broke. The recording has the poses after each step, and in the
    /// step of a break only those of the fragments. They are exact: fragments have the orientation
    /// of the body that broke until the next step, and the centre of their masses is its own.
    #[must_use]
    pub fn poses_at_break(&self) -> BTreeMap<u64, Pose> {
        self.breaks(&self.first_poses())
    }

    fn breaks(&self, first: &BTreeMap<u64, Pose>) -> BTreeMap<u64, Pose> {
        let mut children: BTreeMap<u64, Vec<&Body>> = BTreeMap::new();
        for body in &self.bodies {
            if let Some(parent) = body.parent {
                children.entry(parent).or_default().push(body);
            }
        }
        let mut grains: BTreeMap<u64, (f64, Vec3)> = BTreeMap::new();
        for born in &self.debris {
            let places = born.positions.as_chunks::<3>().0.iter().map(|&place| Vec3::from(place));
            for ((mass, parent), place) in born.masses.iter().zip(&born.parents).zip(places) {
                let sum = grains.entry(*parent).or_insert((0.0, Vec3::zeros()));
                sum.0 += mass;
                sum.1 += place * *mass;
            }
        }
        let of = |(parent, children): (u64, Vec<&Body>)| {
            let placed = children.iter().filter_map(|body| Some((body.mass, first.get(&body.id)?)));
            let placed: Vec<(f64, &Pose)> = placed.collect();
            let turn = placed.first()?.1.rotation;
            let moment = |(mass, pose): &(f64, &Pose)| pose.translation.vector * *mass;
            let mut mass: f64 = placed.iter().map(|(mass, _)| mass).sum();
            let mut sum: Vec3 = placed.iter().map(moment).sum();
            let whole = self.body(parent).map_or(mass, |body| body.mass);
            let lost = grains.get(&parent).filter(|_| mass < whole * (1.0 - WHOLE));
            if let Some((grain_mass, grain_sum)) = lost {
                (mass, sum) = (mass + grain_mass, sum + grain_sum);
            }
            Some((parent, Pose::from_parts((sum / mass).into(), turn)))
        };
        children.into_iter().filter_map(of).collect()
    }

    /// The rest pose of each body: where it was, or would have been as a part of its object, when
    /// the object was first recorded. All fragments at their rest poses make up the object.
    #[must_use]
    pub fn rest_poses(&self) -> BTreeMap<u64, Pose> {
        let first = self.first_poses();
        let breaks = self.breaks(&first);
        let mut rest: BTreeMap<u64, Pose> = BTreeMap::new();
        for body in &self.bodies {
            let Some(own) = first.get(&body.id) else { continue };
            let within = body.parent.and_then(|parent| {
                let (whole, broke) = (rest.get(&parent)?, breaks.get(&parent)?);
                Some(whole * broke.inv_mul(own))
            });
            rest.insert(body.id, within.unwrap_or(*own));
        }
        rest
    }

    /// Where each body lay in the body of the scene that it comes from.
    #[must_use]
    pub fn rest_places(&self) -> BTreeMap<u64, RestPlace> {
        let rest = self.rest_poses();
        let mut places: BTreeMap<u64, RestPlace> = BTreeMap::new();
        // A parent is older than its parts.
        for body in &self.bodies {
            let root = body.parent.map_or(Some(body.id), |it| Some(places.get(&it)?.root));
            let place = root.and_then(|root| {
                let origin = rest.get(&root)?.inv_mul(rest.get(&body.id)?).translation.vector;
                Some(RestPlace { root, origin })
            });
            places.extend(place.map(|place| (body.id, place)));
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PoseRow, Recording, synthetic};
    use cullet_geometry::{Pose, Quat, Vec3};

    /// A body of three parts, one of them grains, that turns as it breaks.
    #[test]
    fn parts_at_rest_make_up_the_body() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        synthetic::run(&path, &synthetic::meta()).expect("a recording");
        let mut recording = Recording::open(&path).expect("it reads");
        // The cube breaks into two parts and a grain, somewhere else and turned.
        let turn = Quat::from_scaled_axis(Vec3::new(0.3, -0.5, 0.2));
        let broke = Pose::from_parts(Vec3::new(0.1, 0.2, 0.7).into(), turn);
        let mass = recording.body(1).expect("the cube").mass;
        let places = [Vec3::new(0.02, 0.0, 0.01), Vec3::new(-0.03, 0.01, 0.0)];
        let share = [0.5 * mass, 0.3 * mass];
        let left = -(places[0] * 0.5 + places[1] * 0.3) / 0.2;
        for (body, share) in recording.bodies.iter_mut().filter(|b| b.id > 1).zip(share) {
            body.mass = share;
        }
        let first =
            recording.poses.iter_mut().find(|poses| poses.ids.contains(&2)).expect("its birth");
        for (part, place) in [2u64, 3].into_iter().zip(places) {
            let row = first.ids.iter().position(|&id| id == part).expect("both are born");
            let at = broke * nalgebra::Point3::from(place);
            first.positions[3 * row..][..3].copy_from_slice(at.coords.as_slice());
            first.rotations[4 * row..][..4].copy_from_slice(turn.coords.as_slice());
        }
        let grain = broke * nalgebra::Point3::from(left);
        recording.debris.truncate(1);
        let born = &mut recording.debris[0];
        born.ids.truncate(1);
        born.parents.truncate(1);
        born.masses = vec![0.2 * mass];
        born.positions = grain.coords.as_slice().to_vec();
        let found = recording.poses_at_break()[&1];
        assert!((found.to_homogeneous() - broke.to_homogeneous()).norm() < 1e-12, "{found}");
        let rest = recording.rest_poses();
        let start = PoseRow::of(&recording.poses[0]).find(|row| row.id == 1).expect("the cube");
        for (part, place) in [2u64, 3].into_iter().zip(places) {
            let wanted = start.pose * Pose::translation(place.x, place.y, place.z);
            let off = (rest[&part].to_homogeneous() - wanted.to_homogeneous()).norm();
            assert!(off < 1e-12, "part {part}: {off}");
        }
        assert_eq!(rest[&1], start.pose);
        let lay = recording.rest_places();
        for (part, place) in [2u64, 3].into_iter().zip(places) {
            assert_eq!(lay[&part].root, 1);
            assert!((lay[&part].origin - place).norm() < 1e-12, "{:?}", lay[&part]);
        }
        assert_eq!((lay[&1].root, lay[&1].origin), (1, Vec3::zeros()));
    }
}
