//! Binary glTF files made by hand: nodes with meshes, their attributes and materials.

/// Triangles of one material, three corners each.
#[derive(Clone, Default)]
pub(crate) struct Primitive {
    pub(crate) positions: Vec<[f32; 3]>,
    /// One a corner, or none.
    pub(crate) normals: Vec<[f32; 3]>,
    /// One a corner, or none; v downward, as glTF has it.
    pub(crate) uv: Vec<[f32; 2]>,
    pub(crate) material: Option<usize>,
}

/// A node with a mesh of its own.
#[derive(Clone, Default)]
pub(crate) struct Node {
    pub(crate) name: &'static str,
    /// Its place as members of a JSON object, such as `"translation":[1,2,3]`.
    pub(crate) place: &'static str,
    pub(crate) primitives: Vec<Primitive>,
}

/// A file of these nodes. `more`: further members of its JSON object, such as `"materials":[…]`;
/// the buffer view 0 is `picture`.
pub(crate) fn glb(nodes: &[Node], more: &str, picture: &[u8]) -> Vec<u8> {
    let mut file = File { blob: Vec::new(), views: Vec::new(), accessors: Vec::new() };
    file.view(picture.to_vec());
    let (mut meshes, mut places) = (Vec::new(), Vec::new());
    for (index, node) in nodes.iter().enumerate() {
        let primitives: Vec<String> = node.primitives.iter().map(|it| file.primitive(it)).collect();
        meshes.push(format!(r#"{{"primitives":[{}]}}"#, primitives.join(",")));
        let name = if node.name.is_empty() {
            String::new()
        } else {
            format!(r#","name":"{}""#, node.name)
        };
        let place = if node.place.is_empty() { String::new() } else { format!(",{}", node.place) };
        places.push(format!(r#"{{"mesh":{index}{name}{place}}}"#));
    }
    let all: Vec<String> = (0..nodes.len()).map(|node| node.to_string()).collect();
    let more = if more.is_empty() { String::new() } else { format!(",{more}") };
    let json = [
        format!(
            r#""asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}]"#,
            all.join(",")
        ),
        format!(r#""nodes":[{}],"meshes":[{}]"#, places.join(","), meshes.join(",")),
        format!(r#""accessors":[{}]"#, file.accessors.join(",")),
        format!(r#""bufferViews":[{}]"#, file.views.join(",")),
        format!(r#""buffers":[{{"byteLength":{}}}]{more}"#, file.blob.len()),
    ];
    let mut json = format!("{{{}}}", json.join(","));
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + file.blob.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((file.blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(file.blob);
    bytes
}

struct File {
    blob: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl File {
    fn primitive(&mut self, primitive: &Primitive) -> String {
        let mut attributes = vec![format!(r#""POSITION":{}"#, self.numbers(&primitive.positions))];
        if !primitive.normals.is_empty() {
            attributes.push(format!(r#""NORMAL":{}"#, self.numbers(&primitive.normals)));
        }
        if !primitive.uv.is_empty() {
            attributes.push(format!(r#""TEXCOORD_0":{}"#, self.numbers(&primitive.uv)));
        }
        let material =
            primitive.material.map(|it| format!(r#","material":{it}"#)).unwrap_or_default();
        format!(r#"{{"attributes":{{{}}}{material}}}"#, attributes.join(","))
    }

    fn numbers<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize {
        let view = self.view(rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect());
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> String {
            let of = |k: usize| rows.iter().map(|row| row[k]).fold(start, pick).to_string();
            (0..N).map(of).collect::<Vec<_>>().join(",")
        };
        let (low, high) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{},"type":"VEC{N}",
            "min":[{low}],"max":[{high}]}}"#,
            rows.len()
        ));
        self.accessors.len() - 1
    }

    fn view(&mut self, mut bytes: Vec<u8>) -> usize {
        let (start, length) = (self.blob.len(), bytes.len().max(1));
        bytes.resize(length.next_multiple_of(4), 0);
        self.blob.extend(bytes);
        let view = format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}}}"#);
        self.views.push(view);
        self.views.len() - 1
    }
}
