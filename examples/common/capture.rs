//! Pictures from a camera without a window.

use bevy::{
    camera::RenderTarget,
    prelude::*,
    render::{
        render_resource::{TextureFormat, TextureUsages},
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
};
use std::{
    path::Path,
    sync::{Arc, Mutex},
};

/// Width and height of a picture in pixels.
pub const PICTURE_SIZE: UVec2 = UVec2::new(1280, 720);

/// Frames to wait for the picture to come back from the adapter.
const READ_BACK_FRAMES: usize = 100;

/// The image that the off-screen camera draws to.
#[derive(Resource, Clone)]
pub struct CaptureTarget(Handle<Image>);

/// Makes the camera draw to an image instead of a window. It is switched off between pictures: a software renderer
/// would take far longer than the simulation.
pub fn aim_at_image(world: &mut World, camera: Entity) {
    let mut image = Image::new_target_texture(PICTURE_SIZE.x, PICTURE_SIZE.y, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let image = world.resource_mut::<Assets<Image>>().add(image);
    world
        .entity_mut(camera)
        .insert((Camera { is_active: false, ..default() }, RenderTarget::Image(image.clone().into())));
    world.insert_resource(CaptureTarget(image));
}

/// Draws the scene as it is now and writes it as a PNG. Game time must stand still meanwhile. Pipelines must be
/// compiled synchronously, or the first pictures lack things.
pub fn take_picture(app: &mut App, camera: Entity, path: &Path) -> Result<(), String> {
    set_active(app, camera, true);
    let picture: Arc<Mutex<Option<Image>>> = default();
    let slot = picture.clone();
    let target = app.world().resource::<CaptureTarget>().0.clone();
    app.world_mut().spawn(Screenshot::image(target)).observe(move |captured: On<ScreenshotCaptured>| {
        if let Ok(mut slot) = slot.lock() {
            *slot = Some(captured.image.clone());
        }
    });
    app.update();
    set_active(app, camera, false);

    for _ in 0..READ_BACK_FRAMES {
        let done = picture.lock().map_err(|error| error.to_string())?.take();
        if let Some(image) = done {
            let image = image.try_into_dynamic().map_err(|error| error.to_string())?;
            let written = image.to_rgb8().save(path);
            return written.map_err(|error| format!("cannot write {}: {error}", path.display()));
        }
        app.update();
    }
    Err(format!("the adapter gave no picture for {}", path.display()))
}

fn set_active(app: &mut App, camera: Entity, active: bool) {
    if let Some(mut camera) = app.world_mut().get_mut::<Camera>(camera) {
        camera.is_active = active;
    }
}
