//! Animations of glTF: how a node moves, with all nodes that it hangs on.

use super::glb::MAX_DEPTH;
use super::gltf_file::{GltfFile, malformed};
use super::{Beside, MeshFileError, hush};
use cullet_geometry::motion::{FrameMotion, MotionLink, MotionTrack, TrackError};
use cullet_geometry::{Pose, Quat};
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Channel, Interpolation, Property};
use nalgebra::{Matrix4, Quaternion, SVector, Vector3, Vector4};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Most keys of all tracks that move a node: an hour at 25 a second.
pub const MAX_MOTION_KEYS: usize = 100_000;

/// Names that an error lists; the others are counted.
const MOST_NAMES: usize = 20;

/// Share by which lengths along the axes may differ and be one scale \[1\]: programs write them as
/// f32.
const EVEN: f64 = 1e-4;

/// How a node moves in one of the animations of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMotion {
    /// The motion of its frame, in the axes and units of the file; `rest` is where the file has it
    /// without the animation.
    pub motion: FrameMotion,
    /// How much larger the node makes what is drawn in its frame, along its axes \[1\].
    pub scale: [f64; 3],
}

/// Why a file has no such motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionFileError {
    /// The bytes are no glTF file.
    #[error(transparent)]
    File(#[from] MeshFileError),
    /// No animation is meant, or one that is not there.
    #[error("{}", no_animation(.wanted.as_deref(), .known))]
    Animation {
        /// The name that was asked for.
        wanted: Option<String>,
        /// Those of the file.
        known: Vec<String>,
    },
    /// No node has that name, or more than one.
    #[error("{}", no_node(.wanted, *.count, .known))]
    Node {
        /// The name that was asked for.
        wanted: String,
        /// How many have it.
        count: usize,
        /// Those of the file.
        known: Vec<String>,
    },
    /// The animation leaves the node where it is.
    #[error(
        "the animation moves neither \"{node}\" nor a node that it hangs on; it moves {}",
        listed(.moved)
    )]
    Still {
        /// The node.
        node: String,
        /// The nodes that it moves.
        moved: Vec<String>,
    },
    /// What a node does is nothing that a rigid body does.
    #[error("the node \"{node}\" {what}")]
    Unlike {
        /// The node.
        node: String,
        /// What it does.
        what: &'static str,
    },
    /// Keys of a channel are wrong.
    #[error("the {property} of the node \"{node}\": {error}")]
    Track {
        /// The node.
        node: String,
        /// Which of its channels.
        property: &'static str,
        /// What is wrong.
        error: TrackError,
    },
    /// More keys than accepted.
    #[error("the channels that move the node have {count} keys; at most {limit} are read")]
    TooLong {
        /// How many there are.
        count: usize,
        /// The bound.
        limit: usize,
    },
}

/// Names in quotes.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none that has a name".to_owned();
    }
    let (first, more) = names.split_at(names.len().min(MOST_NAMES));
    let mut text = format!("\"{}\"", first.join("\", \""));
    if !more.is_empty() {
        let _ = write!(text, " and {} more", more.len());
    }
    text
}

fn no_animation(wanted: Option<&str>, known: &[String]) -> String {
    let has = format!("the file has {}", listed(known));
    match wanted {
        _ if known.is_empty() => "the file has no animations".to_owned(),
        None => format!("`name` is missing: {has}"),
        Some(wanted) if known.iter().any(|name| name == wanted) => {
            format!("more than one animation is called \"{wanted}\"; {has}")
        }
        Some(wanted) => format!("there is no animation \"{wanted}\"; {has}"),
    }
}

fn no_node(wanted: &str, count: usize, known: &[String]) -> String {
    match count {
        0 => format!("there is no node \"{wanted}\"; the file has {}", listed(known)),
        _ => format!("{count} nodes are called \"{wanted}\"; a name must be that of one"),
    }
}

impl MotionFileError {
    /// The key of a scene that names what is wrong: `file`, `name` or `node`.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            Self::File(_) => "file",
            Self::Animation { .. } => "name",
            Self::Node { .. }
            | Self::Still { .. }
            | Self::Unlike { .. }
            | Self::Track { .. }
            | Self::TooLong { .. } => "node",
        }
    }

    /// What was asked for, and what there is in its place.
    #[must_use]
    pub fn sought(&self) -> Option<(&str, &[String])> {
        match self {
            Self::Animation { wanted: Some(wanted), known } => Some((wanted, known)),
            Self::Node { wanted, count: 0, known } => Some((wanted, known)),
            _ => None,
        }
    }
}

/// How a node of a glTF file moves in an animation; in its only one where no name is given.
/// `beside` gives buffers that lie in files of their own.
///
/// # Errors
/// Why the file has no such motion, or none that a rigid body can have.
pub fn node_motion(
    bytes: &[u8],
    beside: &mut Beside<'_>,
    animation: Option<&str>,
    node: &str,
) -> Result<NodeMotion, MotionFileError> {
    // As with meshes: a panic of the reader is an error of the file.
    hush::hushed(|| read(bytes, beside, animation, node))
        .unwrap_or_else(|_| Err(malformed("the reader gave up on these bytes").into()))
}

fn read(
    bytes: &[u8],
    beside: &mut Beside<'_>,
    animation: Option<&str>,
    node: &str,
) -> Result<NodeMotion, MotionFileError> {
    let file = GltfFile::open(bytes, beside)?;
    let chain = chain(&file.document, node)?;
    let animation = chosen(&file.document, animation)?;
    let name = |of: &gltf::Node<'_>| of.name().unwrap_or_default().to_owned();
    let channels: Vec<Channel<'_>> = animation.channels().collect();
    let above: Vec<usize> = chain.iter().map(gltf::Node::index).collect();
    let moves = |channel: &&Channel<'_>| above.contains(&channel.target().node().index());
    let count = channels
        .iter()
        .filter(moves)
        .fold(0_usize, |count, channel| count.saturating_add(channel.sampler().input().count()));
    if count > MAX_MOTION_KEYS {
        return Err(MotionFileError::TooLong { count, limit: MAX_MOTION_KEYS });
    }
    if count == 0 {
        let moved: BTreeSet<String> =
            channels.iter().map(|channel| name(&channel.target().node())).collect();
        let moved = moved.into_iter().filter(|name| !name.is_empty()).collect();
        return Err(MotionFileError::Still { node: node.to_owned(), moved });
    }
    let (mut links, mut still) = (Vec::new(), Vec::new());
    let mut scale = [1.0; 3];
    for (depth, node) in chain.iter().enumerate() {
        let last = depth + 1 == chain.len();
        let at_rest = at_rest(node)?;
        scale = at_rest.scale;
        let even = scale.iter().all(|s| (s - scale[0]).abs() <= EVEN * scale[0].abs());
        if !last && !even {
            let what = "is scaled unevenly, and what hangs on it is sheared: apply its scale";
            return Err(MotionFileError::Unlike { node: name(node), what });
        }
        let of_node = channels.iter().filter(|it| it.target().node().index() == node.index());
        let mut link = at_rest.link();
        still.push(link.clone());
        for channel in of_node {
            moved(&mut link, channel, scale, &file, last)?;
        }
        links.push(link);
    }
    let rest = FrameMotion { links: still, rest: Pose::identity() }.at(0.0);
    Ok(NodeMotion { motion: FrameMotion { links, rest }, scale })
}

/// A node and those that it hangs on, from the outermost to it.
fn chain<'a>(
    file: &'a gltf::Document,
    wanted: &str,
) -> Result<Vec<gltf::Node<'a>>, MotionFileError> {
    let named: Vec<gltf::Node<'a>> =
        file.nodes().filter(|node| node.name() == Some(wanted)).collect();
    let [node] = &named[..] else {
        let known = file.nodes().filter_map(|node| node.name().map(str::to_owned)).collect();
        let (wanted, count) = (wanted.to_owned(), named.len());
        return Err(MotionFileError::Node { wanted, count, known });
    };
    let mut parents: Vec<Option<usize>> = vec![None; file.nodes().len()];
    for node in file.nodes() {
        for child in node.children() {
            if parents[child.index()].replace(node.index()).is_some() {
                return Err(malformed("a node hangs on two others").into());
            }
        }
    }
    if node.skin().is_some() {
        let what = "is deformed by bones: a rigid body is not; give the node of a rigid object";
        return Err(MotionFileError::Unlike { node: wanted.to_owned(), what });
    }
    let mut chain = vec![node.clone()];
    while let Some(above) = parents[chain[chain.len() - 1].index()] {
        if chain.len() > MAX_DEPTH {
            return Err(malformed(&format!("the tree of nodes is deeper than {MAX_DEPTH}")).into());
        }
        chain.extend(file.nodes().nth(above));
    }
    chain.reverse();
    Ok(chain)
}

fn chosen<'a>(
    file: &'a gltf::Document,
    wanted: Option<&str>,
) -> Result<gltf::Animation<'a>, MotionFileError> {
    let all = || file.animations();
    let mut found = all().filter(|it| wanted.is_none_or(|wanted| it.name() == Some(wanted)));
    if let (Some(one), None) = (found.next(), found.next()) {
        return Ok(one);
    }
    let known = all().map(|it| it.name().unwrap_or("(without a name)").to_owned()).collect();
    Err(MotionFileError::Animation { wanted: wanted.map(str::to_owned), known })
}

/// Where a node is in the one that it hangs on, without an animation.
struct NodePlace {
    place: Vector3<f64>,
    turn: Vector4<f64>,
    scale: [f64; 3],
}

impl NodePlace {
    fn link(&self) -> MotionLink {
        MotionLink {
            place: MotionTrack::constant(self.place),
            turn: MotionTrack::constant(self.turn),
            scale: self.scale[0],
        }
    }
}

fn at_rest(node: &gltf::Node<'_>) -> Result<NodePlace, MotionFileError> {
    let unlike =
        |what| MotionFileError::Unlike { node: node.name().unwrap_or_default().to_owned(), what };
    let (place, turn, scale) = node.transform().decomposed();
    let (place, scale) = (Vector3::from(place.map(f64::from)), scale.map(f64::from));
    let turn = Vector4::from(turn.map(f64::from));
    let sound = place.iter().chain(&scale).chain(turn.iter()).all(|x| x.is_finite());
    let Some(turn) = turn.try_normalize(1e-6).filter(|_| sound) else {
        return Err(unlike("has a place or a turn that is no number"));
    };
    if scale.contains(&0.0) {
        return Err(unlike("is scaled to nothing"));
    }
    if let gltf::scene::Transform::Matrix { matrix } = node.transform() {
        let written = Matrix4::from_fn(|row, column| f64::from(matrix[column][row]));
        let rotation = Quat::new_normalize(Quaternion::from(turn)).to_homogeneous();
        let made = rotation * Matrix4::new_nonuniform_scaling(&Vector3::from(scale));
        let off = (written - made).fixed_view::<3, 3>(0, 0).amax();
        if off > EVEN * made.fixed_view::<3, 3>(0, 0).amax() {
            return Err(unlike("is sheared by its matrix"));
        }
    }
    Ok(NodePlace { place, turn, scale })
}

/// Whether a channel says that it has as many values as its times need. An accessor may name any
/// count without having bytes for it, so nothing is read before.
fn counted(channel: &Channel<'_>) -> Result<(), MotionFileError> {
    let sampler = channel.sampler();
    let property = match channel.target().property() {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        // Of those, nothing is read.
        Property::MorphTargetWeights => return Ok(()),
    };
    let (times, values) = (sampler.input().count(), sampler.output().count());
    let each = if sampler.interpolation() == Interpolation::CubicSpline { 3 } else { 1 };
    if times.checked_mul(each) == Some(values) {
        return Ok(());
    }
    let node = channel.target().node().name().unwrap_or_default().to_owned();
    let error = TrackError::Count { times, values: values / each };
    Err(MotionFileError::Track { node, property, error })
}

/// Whether the values of a channel, of which a cubic one has an arrival, a value and a departure
/// for each time, are this scale all the time.
fn keeps_scale(
    times: &[f64],
    values: impl Iterator<Item = [f64; 3]>,
    curve: Interpolation,
    scale: [f64; 3],
) -> bool {
    let span = times[times.len() - 1] - times[0];
    let near = |value: [f64; 3], wanted: [f64; 3]| {
        (0..3).all(|axis| (value[axis] - wanted[axis]).abs() <= EVEN * scale[axis].abs())
    };
    values.enumerate().all(|(index, value)| match curve {
        Interpolation::CubicSpline if index % 3 != 1 => {
            near(value.map(|slope| slope * span), [0.0; 3])
        }
        _ => near(value, scale),
    })
}

/// Puts a channel of a node into its link.
fn moved(
    link: &mut MotionLink,
    channel: &Channel<'_>,
    scale: [f64; 3],
    file: &GltfFile,
    last: bool,
) -> Result<(), MotionFileError> {
    let node = channel.target().node().name().unwrap_or_default().to_owned();
    let unlike = |what| MotionFileError::Unlike { node: node.clone(), what };
    counted(channel)?;
    let reader = channel.reader(|buffer| file.bytes(&buffer));
    let (Some(times), Some(values)) = (reader.read_inputs(), reader.read_outputs()) else {
        return Err(malformed("a channel of an animation cannot be read").into());
    };
    let times: Vec<f64> = times.map(f64::from).collect();
    let curve = channel.sampler().interpolation();
    let bad = |property: &'static str| {
        let node = node.clone();
        move |error: TrackError| MotionFileError::Track { node, property, error }
    };
    let jumps = "jumps (its interpolation is STEP), which a body cannot: make it linear";
    match values {
        ReadOutputs::Translations(values) => {
            let values = values.map(|value| Vector3::from(value.map(f64::from))).collect();
            let track = track(times, values, curve).map_err(bad("translation"))?;
            link.place = track.ok_or_else(|| unlike(jumps))?;
        }
        ReadOutputs::Rotations(values) => {
            let values = values.into_f32().map(|value| Vector4::from(value.map(f64::from)));
            let track = track(times, values.collect(), curve).map_err(bad("rotation"))?;
            link.turn = track.ok_or_else(|| unlike(jumps))?;
        }
        ReadOutputs::Scales(values) => {
            let values = values.map(|value| value.map(f64::from));
            if !keeps_scale(&times, values, curve, scale) {
                return Err(unlike("is scaled by the animation: a rigid body keeps its size"));
            }
        }
        ReadOutputs::MorphTargetWeights(_) if last => {
            return Err(unlike("has shape keys that the animation moves: a rigid body is rigid"));
        }
        ReadOutputs::MorphTargetWeights(_) => {}
    }
    Ok(())
}

/// The track of a channel; nothing of one that jumps.
fn track<const N: usize>(
    times: Vec<f64>,
    values: Vec<SVector<f64, N>>,
    curve: Interpolation,
) -> Result<Option<MotionTrack<N>>, TrackError> {
    match curve {
        Interpolation::Linear => MotionTrack::new(times, values, Vec::new()).map(Some),
        Interpolation::Step => {
            let same = values.iter().all(|value| *value == values[0]);
            let track = MotionTrack::new(times, values, Vec::new())?;
            Ok(same.then_some(track))
        }
        Interpolation::CubicSpline => {
            let (times_count, count) = (times.len(), values.len());
            if count != 3 * times_count {
                // An arrival, a value and a departure each.
                return Err(TrackError::Count { times: times_count, values: count / 3 });
            }
            let slopes = values.chunks_exact(3).map(|key| [key[0], key[2]]).collect();
            let values = values.chunks_exact(3).map(|key| key[1]).collect();
            MotionTrack::new(times, values, slopes).map(Some)
        }
    }
}
