-- Kogao for darktable: two buttons in the module "selected image[s]". Each photo is exported as a
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

-- darktable's scripts can't open a dialog, and widgets created at start can block darktable: the
-- Amount is a preference.
dt.preferences.register("kogao", "amount", "float", "Kogao: @AMOUNT_LABEL@", "@SMALLER@",
  tonumber("@AMOUNT@"), 0, LARGEST, 0.5)

-- Return the command for the Amount of the preferences.
local function smaller()
  local amount = dt.preferences.read("kogao", "amount", "float")
  return SMALLER .. string.format("%.1f", amount):gsub(",", ".")
end

local function register(name, label, command)
  dt.gui.libs.image.register_action(name, label, function(_, images)
    process(command(), images)
  end, "@RESULT_NEXT_TO@")
end

register("kogao_editor", "@EDIT@", function() return EDITOR end)
register("kogao_smaller", (("@SMALLER@"):gsub("…", "")), smaller)

return { process = process, smaller = smaller }
