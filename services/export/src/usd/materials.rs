//! Materials of a stage, as previews that all programs read.

use crate::pictures::{ArtistMaterial, ExportPicture};
use cullet_geometry::attributes::{TextureMapping, TextureWrap};
use std::fmt::Write;

const INDENT: &str = "            ";

/// A material of one colour: linear red, green and blue.
pub(super) fn plain(name: &str, [r, g, b]: [f32; 3], metallic: f32, roughness: f32) -> String {
    let colour = format!("color3f inputs:diffuseColor = ({r}, {g}, {b})");
    material(name, &colour, metallic, roughness, "")
}

/// A material whose colour is that of the points, and is no metal.
pub(super) fn of_points(name: &str, roughness: f32) -> String {
    let from = format!("</World/Looks/{name}/colour.outputs:result>");
    let colour = format!("color3f inputs:diffuseColor.connect = {from}");
    let shader = format!(
        "\n{INDENT}def Shader \"colour\"\n{INDENT}{{\n{INDENT}    \
         uniform token info:id = \"UsdPrimvarReader_float3\"\n{INDENT}    \
         string inputs:varname = \"displayColor\"\n{INDENT}    float3 outputs:result\n{INDENT}}}\n"
    );
    material(name, &colour, 0.0, roughness, &shader)
}

/// A material of an artist's mesh. `folder`: where its picture lies, from where the stage lies.
pub(super) fn artist(name: &str, of: &ArtistMaterial, folder: &str) -> String {
    let ArtistMaterial { look, picture } = of;
    let [r, g, b, _] = look.base_colour;
    let Some(picture) = picture else {
        return plain(name, [r, g, b], look.metallic, look.roughness);
    };
    let colour =
        format!("color3f inputs:diffuseColor.connect = </World/Looks/{name}/picture.outputs:rgb>");
    let mut shaders = format!(
        "\n{INDENT}def Shader \"coordinates\"\n{INDENT}{{\n{INDENT}    \
         uniform token info:id = \"UsdPrimvarReader_float2\"\n{INDENT}    \
         string inputs:varname = \"st\"\n{INDENT}    float2 outputs:result\n{INDENT}}}\n"
    );
    let (mapping, mut from) = (of.mapping(), "coordinates");
    if !mapping.is_straight() {
        shaders += &transform(name, mapping);
        from = "transform";
    }
    shaders += &texture(picture, folder, mapping.wrap, [r, g, b]);
    let _ = write!(
        shaders,
        "{INDENT}    float2 inputs:st.connect = </World/Looks/{name}/{from}.outputs:result>\n\
         {INDENT}    float3 outputs:rgb\n{INDENT}}}\n"
    );
    material(name, &colour, look.metallic, look.roughness, &shaders)
}

/// `colour`: the attribute that says what colour it has; `shaders`: what it reads.
fn material(name: &str, colour: &str, metallic: f32, roughness: f32, shaders: &str) -> String {
    format!(
        "        def Material \"{name}\"\n        {{\n\
         {INDENT}token outputs:surface.connect = </World/Looks/{name}/preview.outputs:surface>\n\n\
         {INDENT}def Shader \"preview\"\n{INDENT}{{\n\
         {INDENT}    uniform token info:id = \"UsdPreviewSurface\"\n{INDENT}    {colour}\n\
         {INDENT}    float inputs:metallic = {metallic}\n\
         {INDENT}    float inputs:roughness = {roughness}\n\
         {INDENT}    token outputs:surface\n{INDENT}}}\n{shaders}        }}\n\n"
    )
}

/// The begin of the shader that reads a picture, and multiplies it by the base colour.
fn texture(
    picture: &ExportPicture,
    folder: &str,
    wrap: [TextureWrap; 2],
    [r, g, b]: [f32; 3],
) -> String {
    let [s, t] = wrap.map(|wrap| match wrap {
        TextureWrap::Repeat => "repeat",
        TextureWrap::Mirror => "mirror",
        TextureWrap::Clamp => "clamp",
    });
    let file = format!("./{folder}/{}", picture.file());
    format!(
        "\n{INDENT}def Shader \"picture\"\n{INDENT}{{\n\
         {INDENT}    uniform token info:id = \"UsdUVTexture\"\n\
         {INDENT}    asset inputs:file = @{file}@\n\
         {INDENT}    float4 inputs:scale = ({r}, {g}, {b}, 1)\n\
         {INDENT}    token inputs:sourceColorSpace = \"sRGB\"\n\
         {INDENT}    token inputs:wrapS = \"{s}\"\n{INDENT}    token inputs:wrapT = \"{t}\"\n"
    )
}

/// How coordinates lead into a picture. glTF counts v from the top, and turns about the top left
/// corner; USD from the bottom, and turns about the bottom left.
pub(super) fn upward(mapping: TextureMapping) -> ([f32; 2], f32, [f32; 2]) {
    let TextureMapping { offset: [u, v], rotation, scale: [s, t], .. } = mapping;
    let (sine, cosine) = rotation.sin_cos();
    ([u + t * sine, 1.0 - v - t * cosine], rotation.to_degrees(), [s, t])
}

fn transform(name: &str, mapping: TextureMapping) -> String {
    let ([u, v], degrees, [s, t]) = upward(mapping);
    format!(
        "\n{INDENT}def Shader \"transform\"\n{INDENT}{{\n\
         {INDENT}    uniform token info:id = \"UsdTransform2d\"\n\
         {INDENT}    float2 inputs:in.connect = </World/Looks/{name}/coordinates.outputs:result>\n\
         {INDENT}    float inputs:rotation = {degrees}\n\
         {INDENT}    float2 inputs:scale = ({s}, {t})\n\
         {INDENT}    float2 inputs:translation = ({u}, {v})\n\
         {INDENT}    float2 outputs:result\n{INDENT}}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where glTF reads a picture, v downward: scaled, turned, moved.
    fn of_gltf(mapping: TextureMapping, [u, v]: [f32; 2]) -> [f32; 2] {
        let (sine, cosine) = mapping.rotation.sin_cos();
        let [u, v] = [mapping.scale[0] * u, mapping.scale[1] * v];
        [cosine * u + sine * v + mapping.offset[0], cosine * v - sine * u + mapping.offset[1]]
    }

    #[test]
    fn a_picture_lies_where_gltf_has_it() {
        let (offset, scale) = ([0.3, -0.2], [2.0, 0.5]);
        let mapping = TextureMapping { offset, rotation: 0.7, scale, ..TextureMapping::default() };
        let ([du, dv], degrees, [s, t]) = upward(mapping);
        let (sine, cosine) = degrees.to_radians().sin_cos();
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.25, 0.75]] {
            let [x, y] = of_gltf(mapping, [u, 1.0 - v]);
            let [u, v] = [s * u, t * v];
            let own = [cosine * u - sine * v + du, sine * u + cosine * v + dv];
            assert!((own[0] - x).abs() + (own[1] - (1.0 - y)).abs() < 1e-5, "{own:?}");
        }
    }
}
