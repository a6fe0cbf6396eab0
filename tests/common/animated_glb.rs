//! Binary glTF files with animations, made by hand.

/// A channel of an animation.
#[derive(Clone)]
pub(crate) struct GlbChannel {
    /// Place of its animation in the list of names.
    pub(crate) animation: usize,
    /// Place of the node that it moves.
    pub(crate) node: usize,
    /// `translation`, `rotation`, `scale` or `weights`.
    pub(crate) path: &'static str,
    /// `LINEAR`, `STEP` or `CUBICSPLINE`.
    pub(crate) curve: &'static str,
    pub(crate) times: Vec<f32>,
    /// All numbers of its values, one value after another.
    pub(crate) values: Vec<f32>,
}

/// The corner triangles of a box from `low` to `high`, outward.
fn box_corners(low: [f32; 3], high: [f32; 3]) -> Vec<[f32; 3]> {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        [pick(0), pick(1), pick(2)]
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
    halves.map(corner).collect()
}

/// A file of nodes, each as the members of its JSON object; mesh 0 is a box. The scene has the node
/// 0, all others hang on it. `more`: further members of the file's object, such as `"skins":[…]`.
pub(crate) fn animated_glb(
    nodes: &[&str],
    (low, high): ([f32; 3], [f32; 3]),
    animations: &[&str],
    channels: &[GlbChannel],
    more: &str,
) -> Vec<u8> {
    let mut parts = GlbParts::default();
    let corners: Vec<f32> = box_corners(low, high).into_iter().flatten().collect();
    parts.accessor(&corners, 3);
    let mut written: Vec<(Vec<String>, Vec<String>)> = vec![Default::default(); animations.len()];
    for channel in channels {
        let width = match channel.path {
            "rotation" => 4,
            "weights" => 1,
            _ => 3,
        };
        let input = parts.accessor(&channel.times, 1);
        let output = parts.accessor(&channel.values, width);
        let (samplers, of) = &mut written[channel.animation];
        of.push(format!(
            r#"{{"sampler":{},"target":{{"node":{},"path":"{}"}}}}"#,
            samplers.len(),
            channel.node,
            channel.path
        ));
        let curve = channel.curve;
        samplers
            .push(format!(r#"{{"input":{input},"output":{output},"interpolation":"{curve}"}}"#));
    }
    let written = animations.iter().zip(written).map(|(name, (samplers, of))| {
        let name = if name.is_empty() { String::new() } else { format!(r#""name":"{name}","#) };
        format!(r#"{{{name}"samplers":[{}],"channels":[{}]}}"#, samplers.join(","), of.join(","))
    });
    let written: Vec<String> = written.collect();
    let nodes: Vec<String> = nodes.iter().map(|node| format!("{{{node}}}")).collect();
    let list = |name: &str, items: &[String]| match items {
        [] => String::new(),
        _ => format!(r#","{name}":[{}]"#, items.join(",")),
    };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"byteLength":{}}}]{}{}{}{}{}}}"#,
        parts.blob.len(),
        list("nodes", &nodes),
        list("accessors", &parts.accessors),
        list("bufferViews", &parts.views),
        list("animations", &written),
        if more.is_empty() { String::new() } else { format!(",{more}") },
    );
    packed(json, parts.blob)
}

/// The file of two chunks.
pub(crate) fn packed(mut json: String, blob: Vec<u8>) -> Vec<u8> {
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + blob.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
}

/// What accessors lead to.
#[derive(Default)]
struct GlbParts {
    blob: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl GlbParts {
    /// Numbers, so many to a value; says where the accessor is in the list.
    fn accessor(&mut self, numbers: &[f32], width: usize) -> usize {
        let kind = ["", "SCALAR", "", "VEC3", "VEC4"][width];
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> String {
            let of = |k: usize| {
                numbers.iter().skip(k).step_by(width).copied().fold(start, pick).to_string()
            };
            (0..width).map(of).collect::<Vec<_>>().join(",")
        };
        let (low, high) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let (start, length) = (self.blob.len(), numbers.len() * 4);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}}}"#));
        self.blob.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        let (view, count) = (self.views.len() - 1, numbers.len() / width);
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{count},"type":"{kind}",
            "min":[{low}],"max":[{high}]}}"#
        ));
        self.accessors.len() - 1
    }
}
