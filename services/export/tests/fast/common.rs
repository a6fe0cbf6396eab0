//! A recording, and a reader of GLB files.

use cullet_export::{ExportOptions, export};
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_record::{Recording, synthetic};
use gltf::animation::Interpolation;
use gltf::animation::util::ReadOutputs;
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::TempDir;

/// A cube that falls onto a slab, splits in two and loses two grains; a recording of it, and a
/// folder for what is exported.
pub(crate) struct Fixture {
    pub(crate) folder: TempDir,
    pub(crate) recording: Recording,
}

pub(crate) fn fixture() -> Fixture {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    synthetic::run(&path, &synthetic::meta()).expect("a recording");
    let recording = Recording::open(&path).expect("it reads");
    Fixture { folder, recording }
}

impl Fixture {
    /// The run as a GLB.
    pub(crate) fn glb(&self, options: &ExportOptions) -> GlbScene {
        let path = self.folder.path().join("x.glb");
        export(&self.recording, options, &path).expect("it is exported");
        GlbScene::read(&path)
    }

    /// The run as a text of that ending.
    pub(crate) fn text(&self, name: &str, options: &ExportOptions) -> String {
        let path = self.folder.path().join(name);
        export(&self.recording, options, &path).expect("it is exported");
        std::fs::read_to_string(&path).expect("a text")
    }
}

/// Keys of one property: times \[s\], values, and whether it jumps from one to the next.
struct Keys {
    times: Vec<f32>,
    values: Vec<Vec<f32>>,
    jumps: bool,
}

/// A GLB that was read back.
pub(crate) struct GlbScene {
    pub(crate) document: gltf::Document,
    pub(crate) blob: Vec<u8>,
    /// By node and by property.
    keys: BTreeMap<(usize, &'static str), Keys>,
}

impl GlbScene {
    pub(crate) fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("a file");
        Self::of(gltf::Gltf::from_slice(&bytes).expect("a GLB"))
    }

    /// That of a page, which demands an extension that this reader has but does not name.
    pub(crate) fn of_page(bytes: &[u8]) -> Self {
        Self::of(gltf::Gltf::from_slice_without_validation(bytes).expect("a GLB"))
    }

    fn of(gltf::Gltf { document, blob }: gltf::Gltf) -> Self {
        let blob = blob.expect("a binary part");
        let mut keys = BTreeMap::new();
        for channel in
            document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>())
        {
            let reader = channel.reader(|_| Some(&blob));
            let times: Vec<f32> = reader.read_inputs().expect("times").collect();
            let (property, values): (_, Vec<Vec<f32>>) = match reader.read_outputs() {
                Some(ReadOutputs::Translations(all)) => {
                    ("place", all.map(|v| v.to_vec()).collect())
                }
                Some(ReadOutputs::Scales(all)) => ("scale", all.map(|v| v.to_vec()).collect()),
                Some(ReadOutputs::Rotations(all)) => {
                    ("turn", all.into_f32().map(|v| v.to_vec()).collect())
                }
                Some(ReadOutputs::MorphTargetWeights(all)) => {
                    let all: Vec<f32> = all.into_f32().collect();
                    let each = all.len() / times.len();
                    ("shapes", all.chunks(each).map(<[f32]>::to_vec).collect())
                }
                None => panic!("an animation of something else"),
            };
            assert_eq!(times.len(), values.len());
            assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
            let jumps = channel.sampler().interpolation() == Interpolation::Step;
            let node = channel.target().node().index();
            let known = keys.insert((node, property), Keys { times, values, jumps });
            assert!(known.is_none(), "two channels of one property");
        }
        Self { document, blob, keys }
    }

    /// The nodes of bodies, by the number of the body.
    pub(crate) fn bodies(&self) -> BTreeMap<u64, gltf::Node<'_>> {
        let id =
            |node: &gltf::Node<'_>| self.facts(node).get("id").and_then(serde_json::Value::as_u64);
        self.document.nodes().filter_map(|node| Some((id(&node)?, node))).collect()
    }

    pub(crate) fn facts(&self, node: &gltf::Node<'_>) -> serde_json::Value {
        let text = node.extras().as_ref().map_or("null", |raw| raw.get());
        serde_json::from_str(text).expect("JSON")
    }

    fn at(&self, node: usize, property: &'static str, time: f64) -> Option<[Vec<f32>; 2]> {
        let keys = self.keys.get(&(node, property))?;
        let next = keys.times.partition_point(|&t| f64::from(t) <= time);
        let last = next.saturating_sub(1);
        let next = next.min(keys.times.len() - 1);
        let [from, to] = [last, next].map(|k| f64::from(keys.times[k]));
        let share = if keys.jumps || to <= from { 0.0 } else { (time - from) / (to - from) };
        let share = share.clamp(0.0, 1.0) as f32;
        Some([keys.values[last].clone(), [&keys.values[next][..], &[share]].concat()])
    }

    /// How much of each shape of its mesh a node has at a time of the file \[s\].
    pub(crate) fn shapes(&self, node: &gltf::Node<'_>, time: f64) -> Vec<f32> {
        let Some([from, to]) = self.at(node.index(), "shapes", time) else { return Vec::new() };
        let (share, to) = to.split_last().expect("a share");
        from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
    }

    /// Where a body is at a time of the file \[s\], in axes whose up is z.
    pub(crate) fn pose(&self, node: &gltf::Node<'_>, time: f64) -> Pose {
        let (place, turn, _) = node.transform().decomposed();
        let place = self.at(node.index(), "place", time).map_or(place.map(f64::from), |[a, b]| {
            std::array::from_fn(|k| f64::from(a[k]) + f64::from(b[3]) * f64::from(b[k] - a[k]))
        });
        let quaternion = |q: &[f32]| {
            let [x, y, z, w] = std::array::from_fn(|k| f64::from(q[k]));
            Quat::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
        };
        let turn = self.at(node.index(), "turn", time).map_or(quaternion(&turn), |[a, b]| {
            quaternion(&a).slerp(&quaternion(&b[..4]), f64::from(b[4]))
        });
        let z_up = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
        let pose = Pose::from_parts(Vec3::from(place).into(), turn);
        z_up * pose * z_up.inverse()
    }

    /// Whether a node is seen at a time of the file \[s\].
    pub(crate) fn is_seen(&self, node: &gltf::Node<'_>, time: f64) -> bool {
        let (.., scale) = node.transform().decomposed();
        let jumps = self.keys.get(&(node.index(), "scale")).is_none_or(|keys| keys.jumps);
        assert!(jumps, "a scale that grows");
        let scale = self.at(node.index(), "scale", time).map_or(scale[0], |[a, _]| a[0]);
        assert!(scale == 0.0 || scale > 1e-4, "a scale of {scale}");
        scale > 0.0
    }
}

/// A row of numbers that look random, in \[0, 1\).
pub(crate) fn random(count: u64) -> impl Iterator<Item = f64> {
    (0..count).map(|k| cullet_geometry::math::unit(11, 5, k))
}

/// How far two poses are apart: the greatest difference of their matrices.
pub(crate) fn apart(a: &Pose, b: &Pose) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}
