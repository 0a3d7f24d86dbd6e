// SPDX-License-Identifier: MIT
// dermis: pressure on skin in, mechanoreceptor responses out.
//
//     dermis::Result r = dermis::run(dermis::Scene::from_file("scene.toml"));
//
// This header is the whole library except Vulkan recording (vulkan.hpp) and contacts (contact.hpp, touch.hpp). A
// simulator that presses skins without scenes needs skin.hpp alone, and the library dermis::core.
#pragma once

#include <dermis/description.hpp>
#include <dermis/device.hpp>
#include <dermis/run.hpp>
#include <dermis/scene.hpp>
#include <dermis/skin.hpp>
#include <dermis/version.hpp>
