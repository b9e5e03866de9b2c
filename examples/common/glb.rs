//! Triangle meshes as binary glTF: what every viewer and Bevy itself can open.

use bevy::math::{Vec2, Vec3};
use gltf::binary::{Glb, Header};
use serde_json::{Value, json};
use std::borrow::Cow;

/// One mesh of a glTF file, in a node of its own. Every list has one entry per vertex or is empty.
#[derive(Default)]
pub struct GlbMesh {
    pub name: String,
    /// In metres.
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// The attribute `_CLOTH_PIN`: vertices of weight 1 are held.
    pub pins: Vec<f32>,
    /// Three per triangle.
    pub indices: Vec<u32>,
    /// Linear RGBA.
    pub base_color: [f32; 4],
    /// A PNG file for the base colour.
    pub texture: Option<Vec<u8>>,
}

/// The bytes of a `.glb` file with these meshes.
pub fn to_glb(meshes: &[GlbMesh]) -> Result<Vec<u8>, String> {
    let mut file = File::default();
    for mesh in meshes {
        file.add(mesh);
    }
    file.finish()
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
}

impl File {
    fn add(&mut self, mesh: &GlbMesh) {
        let lists = [
            ("POSITION", "VEC3", 3, flat(&mesh.positions, |v| v.to_array())),
            ("NORMAL", "VEC3", 3, flat(&mesh.normals, |v| v.to_array())),
            ("TEXCOORD_0", "VEC2", 2, flat(&mesh.uvs, |v| v.to_array())),
            ("_CLOTH_PIN", "SCALAR", 1, mesh.pins.clone()),
        ];
        let mut attributes = serde_json::Map::new();
        for (name, kind, components, numbers) in lists.into_iter().filter(|(_, _, _, numbers)| !numbers.is_empty()) {
            let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
            let accessor = self.accessor(&bytes, numbers.len() / components, FLOAT, kind, ARRAY_BUFFER);
            attributes.insert(name.into(), json!(accessor));
            if name == "POSITION" {
                let (least, greatest) = bounds(&mesh.positions);
                self.accessors[accessor]["min"] = json!(least.to_array());
                self.accessors[accessor]["max"] = json!(greatest.to_array());
            }
        }
        let bytes: Vec<u8> = mesh.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let indices = self.accessor(&bytes, mesh.indices.len(), UNSIGNED_INT, "SCALAR", ELEMENT_ARRAY_BUFFER);

        let mut surface = json!({
            "baseColorFactor": mesh.base_color, "metallicFactor": 0.0, "roughnessFactor": 0.9,
        });
        if let Some(png) = &mesh.texture {
            let view = self.view(png, None);
            self.images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
            self.textures.push(json!({ "source": self.images.len() - 1 }));
            surface["baseColorTexture"] = json!({ "index": self.textures.len() - 1 });
        }
        self.materials.push(json!({ "name": mesh.name, "doubleSided": true, "pbrMetallicRoughness": surface }));
        self.meshes.push(json!({
            "name": mesh.name,
            "primitives": [{
                "attributes": attributes, "indices": indices, "material": self.materials.len() - 1,
            }],
        }));
        self.nodes.push(json!({ "name": mesh.name, "mesh": self.meshes.len() - 1 }));
    }

    fn accessor(&mut self, bytes: &[u8], count: usize, component: u32, kind: &str, target: u32) -> usize {
        let view = self.view(bytes, Some(target));
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        // Accessors of 4-byte numbers must start at a multiple of 4.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn finish(self) -> Result<Vec<u8>, String> {
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "bevy_cloth" },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }],
        });
        // glTF forbids empty lists.
        if !self.images.is_empty() {
            root["images"] = json!(self.images);
            root["textures"] = json!(self.textures);
        }
        let json = serde_json::to_vec(&root).map_err(|error| error.to_string())?;
        let glb = Glb {
            // The length is filled in when the file is written.
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: Cow::Owned(json),
            bin: Some(Cow::Owned(self.bytes)),
        };
        glb.to_vec().map_err(|error| error.to_string())
    }
}

fn flat<T, const N: usize>(list: &[T], numbers: impl Fn(&T) -> [f32; N]) -> Vec<f32> {
    list.iter().flat_map(numbers).collect()
}

fn bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    positions.iter().fold((Vec3::MAX, Vec3::MIN), |(least, greatest), &p| (least.min(p), greatest.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_reads_back() {
        let triangle = GlbMesh {
            name: "sail".into(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            pins: vec![0.0, 0.0, 1.0],
            indices: vec![0, 1, 2],
            base_color: [1.0; 4],
            texture: None,
        };
        let bytes = to_glb(&[triangle]).expect("written");
        let file = gltf::Gltf::from_slice(&bytes).expect("valid glTF");
        let blob = file.blob.as_deref().expect("a binary chunk");
        assert_eq!(file.nodes().next().and_then(|node| node.name()), Some("sail"));
        let primitive = file.meshes().next().and_then(|mesh| mesh.primitives().next()).expect("a primitive");
        let position = primitive.get(&gltf::Semantic::Positions).expect("positions");
        assert_eq!((position.count(), position.max()), (3, Some(json!([1.0, 1.0, 0.0]))));
        let view = primitive.indices().and_then(|accessor| accessor.view()).expect("indices");
        assert_eq!(blob[view.offset()..][..12], [0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    }
}
