-- Kogao for darktable: a panel of the lighttable with the Amount. Each photo is exported as a
-- 16-bit TIFF; the result is imported next to the photo and grouped with it.
-- `kogao-cli integrate darktable` installs this file and fills in programs and texts.

local dt = require "darktable"

-- A Flatpak starts Kogao outside of its sandbox. Other programs can't see the sandbox's /tmp, but
-- its cache is an ordinary folder.
local SANDBOXED = os.getenv("FLATPAK_ID") ~= nil
local LAUNCHER = SANDBOXED and "flatpak-spawn --host " or ""
local FOLDER = SANDBOXED and os.getenv("XDG_CACHE_HOME") or dt.configuration.tmp_dir
local EDITOR = LAUNCHER .. "@KOGAO@ --edit --temporary"
local SMALLER = LAUNCHER .. "@KOGAO_CLI@ warp --in-place --temporary --amount "
local NO_FACE, CANCELLED = 4, 6 -- exit codes
local LARGEST = 15

local function quoted(path)
  if dt.configuration.running_os == "windows" then
    return '"' .. path .. '"'
  end
  return "'" .. path:gsub("'", "'\\''") .. "'"
end

local function exists(path)
  local file = io.open(path, "rb")
  if file then
    file:close()
  end
  return file ~= nil
end

-- Return the path of a TIFF in a folder that does not exist yet, named after the photo.
local function free_name(folder, image, mark)
  local stem = folder .. "/" .. image.filename:gsub("%.[^.]*$", "") .. mark
  local name, number = stem .. ".tif", 1
  while exists(name) do
    name, number = stem .. "_" .. number .. ".tif", number + 1
  end
  return name
end

local function copy(from, to)
  local source = assert(io.open(from, "rb"))
  local data = source:read("a")
  source:close()
  local target = assert(io.open(to, "wb"))
  target:write(data)
  target:close()
end

-- Run a command on a file. Return the exit code and the last line on stderr.
local function run(command, file)
  local errors = file .. ".errors"
  local code = dt.control.execute(command .. " " .. quoted(file) .. " 2>" .. quoted(errors))
  if code > 255 then -- the wait status of POSIX systems
    code = code // 256
  end
  local last = "Kogao: " .. code
  if exists(errors) then
    for line in io.lines(errors) do
      last = line:match("%S") and line or last
    end
    os.remove(errors)
  end
  return code, last
end

-- Return the message for an exit code, with the photo's name instead of the temporary file.
local function problem(code, last, file, image)
  if code == NO_FACE then
    return image.filename .. ": @NO_FACE@"
  end
  local from, to = last:find(file, 1, true)
  if from then
    last = last:sub(1, from - 1) .. image.filename .. last:sub(to + 1)
  end
  return (last:gsub("^kogao%-cli: ", ""))
end

local function import(image, file)
  local name = free_name(image.path, image, "_kogao")
  copy(file, name)
  local result = dt.database.import(name)
  result:group_with(image.group_leader)
  result.rating = image.rating
  for _, tag in ipairs(image:get_tags()) do
    if not tag.name:match("^darktable|") then
      result:attach_tag(tag)
    end
  end
end

-- Process photos one by one. Photos that the user doesn't save stay as they are, without a message.
local function process(command, images)
  for _, image in ipairs(images) do
    local file = free_name(FOLDER, image, "")
    local format = dt.new_format("tiff")
    format.bpp = 16
    format:write_image(image, file)
    local code, last = run(command, file)
    if code == 0 then
      import(image, file)
    elseif code ~= CANCELLED then
      dt.print(problem(code, last, file, image))
    end
    os.remove(file)
  end
end

-- The Amount: a slider of the panel, and the value that the panel starts with.
local slider
local stored = dt.preferences.read("kogao", "amount", "float")
local amount = stored > 0 and stored or tonumber("@AMOUNT@")

-- Return the command for the Amount of the slider.
local function smaller()
  if slider then
    amount = slider.value
    dt.preferences.write("kogao", "amount", "float", amount)
  end
  return SMALLER .. string.format("%.1f", amount):gsub(",", ".")
end

local function button(label, command)
  return dt.new_widget("button"){
    label = label, tooltip = "@RESULT_NEXT_TO@",
    clicked_callback = function() process(command(), dt.gui.action_images) end,
  }
end

local function add_panel()
  slider = dt.new_widget("slider"){
    label = "@AMOUNT_LABEL@", hard_min = 0, hard_max = LARGEST, soft_min = 0, soft_max = LARGEST,
    step = 0.5, digits = 1,
  }
  slider.value = amount -- after the limits, which a table sets in any order
  dt.register_lib("kogao", "Kogao", true, false,
    {[dt.gui.views.lighttable] = {"DT_UI_CONTAINER_PANEL_RIGHT_CENTER", 0}},
    dt.new_widget("box"){
      slider,
      button((("@SMALLER@"):gsub("…", "")), smaller),
      button("@EDIT@", function() return EDITOR end),
    })
end

-- Widgets created before darktable handles events can block darktable. The pointer on a photo shows
-- that darktable does.
dt.register_event("kogao", "mouse-over-image-changed", function(_, image)
  if image and not slider then
    add_panel()
  end
end)

return { process = process, smaller = smaller, slider = function() return slider end }
