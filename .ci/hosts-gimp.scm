; GIMP 3 without a window: 8, 16 and 32 bits, RGB and grey, with and without alpha, with a selection.
; Prints a line for each layer that comes back.
(define (tell text) (gimp-message text))
(define (try name precision grey alpha select)
  (let* ((image (car (gimp-file-load RUN-NONINTERACTIVE "/tmp/hosts/face.jpg")))
         (layer (vector-ref (car (gimp-image-get-layers image)) 0)))
    (if (not (= precision PRECISION-U8-NON-LINEAR)) (gimp-image-convert-precision image precision))
    (if grey (gimp-image-convert-grayscale image))
    (if alpha (gimp-layer-add-alpha layer))
    (if select (gimp-image-select-rectangle image CHANNEL-OP-REPLACE 300 400 100 100))
    (kogao-smaller #:run-mode RUN-NONINTERACTIVE #:image image
                   #:drawables (car (gimp-image-get-layers image)) #:amount 7)
    (let ((layers (car (gimp-image-get-layers image))))
      (gimp-message (string-append "HOSTS " name " layers " (number->string (vector-length layers))
                          " " (car (gimp-item-get-name (vector-ref layers 0)))))
      (gimp-selection-none image)
      (gimp-file-save RUN-NONINTERACTIVE image
                      (string-append "/tmp/hosts/gimp-" name ".tif")))
    (gimp-image-delete image)))
(define (hosts-gimp)
  (for-each
    (lambda (depth)
      (try (string-append (car depth) "-rgb") (cadr depth) #f #f #f)
      (try (string-append (car depth) "-grey") (cadr depth) #t #f #f)
      (try (string-append (car depth) "-rgb-alpha-selection") (cadr depth) #f #t #t)
      (try (string-append (car depth) "-grey-alpha") (cadr depth) #t #t #f))
    (list (list "8" PRECISION-U8-NON-LINEAR) (list "16" PRECISION-U16-NON-LINEAR)
          (list "32" PRECISION-FLOAT-NON-LINEAR))))
