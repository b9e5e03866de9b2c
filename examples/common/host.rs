//! What the machine offers: a display to open a window on, and a graphics adapter to draw with.

use bevy::{
    render::settings::{Backends, WgpuFeatures, WgpuLimits, WgpuSettings, WgpuSettingsPriority},
    tasks::block_on,
};
use wgpu::{DeviceDescriptor, Instance, InstanceDescriptor, RequestAdapterOptions};

/// What a user without any adapter can install to get pictures.
pub const NO_ADAPTER_HINT: &str =
    "no graphics adapter found, so no pictures: install a Vulkan driver (Debian, Ubuntu: mesa-vulkan-drivers)";

/// A graphics adapter that gave a device, and the settings that make Bevy choose it.
pub struct Adapter {
    pub settings: WgpuSettings,
    /// Name and backend, for messages.
    pub name: String,
}

/// The first usable adapter: Vulkan, Metal or DirectX 12, else OpenGL; software drivers count.
///
/// Bevy's renderer panics when there is none; asking first lets an app go on without pictures.
pub fn find_adapter() -> Option<Adapter> {
    candidates().into_iter().find_map(probe)
}

fn candidates() -> Vec<WgpuSettings> {
    // The user's own choice wins.
    if Backends::from_env().is_some() || std::env::var_os("WGPU_SETTINGS_PRIO").is_some() {
        return vec![WgpuSettings::default()];
    }
    let native = WgpuSettings { backends: Some(Backends::PRIMARY), ..WgpuSettings::default() };
    // OpenGL offers less than Bevy asks for by default: keep to the WebGL 2 subset.
    let gl = WgpuSettings {
        backends: Some(Backends::GL),
        priority: WgpuSettingsPriority::WebGL2,
        limits: WgpuLimits::downlevel_webgl2_defaults(),
        ..WgpuSettings::default()
    };
    vec![native, gl]
}

fn probe(settings: WgpuSettings) -> Option<Adapter> {
    let mut descriptor = InstanceDescriptor::new_without_display_handle();
    descriptor.backends = settings.backends?;
    let instance = Instance::new(descriptor);
    let options = RequestAdapterOptions { power_preference: settings.power_preference, ..Default::default() };
    let adapter = block_on(instance.request_adapter(&options)).ok()?;
    let required_limits = match settings.priority {
        WgpuSettingsPriority::Functionality => adapter.limits(),
        _ => settings.limits.clone(),
    };
    let device = DeviceDescriptor { required_limits, required_features: WgpuFeatures::empty(), ..Default::default() };
    block_on(adapter.request_device(&device)).ok()?;
    let info = adapter.get_info();
    Some(Adapter { settings, name: format!("{} ({})", info.name, info.backend) })
}

/// Whether a window can be opened.
#[cfg(target_os = "linux")]
pub fn has_display() -> bool {
    // The examples are built for X11 only, so a Wayland socket alone is not enough. The event loop panics when
    // nobody answers, so try the connection.
    x11rb::connect(None).is_ok()
}

/// Whether a window can be opened.
#[cfg(not(target_os = "linux"))]
pub fn has_display() -> bool {
    true
}
